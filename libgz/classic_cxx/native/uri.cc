// URIs, and those of what is in a world; and the names that plugins register. License: Apache License 2.0.
#include <algorithm>
#include <random>

#include "bridge.hh"
#include "gazebo/libgz/introspection.hh"
#include "gazebo/libgz/uri.hh"

namespace gazebo {
namespace common {

static void warn_of(const char *kind, const std::string &text)
{
  gzwarn << "Unable to parse " << kind << " [" << text << "]. Ignoring." << std::endl;
}

URIPath::URIPath(const std::string &text)
{
  if (!this->Parse(text))
    warn_of("URIPath", text);
}
std::string URIPath::Str(const std::string &delimiter) const
{
  std::string text;
  for (const std::string &part : this->parts)
    text += (text.empty() ? "" : delimiter) + part;
  return text;
}
bool URIPath::Valid(const std::string &text)
{
  return text.find_first_not_of('/') != std::string::npos && text.find_first_of(" ?=&") == std::string::npos;
}
bool URIPath::Parse(const std::string &text)
{
  if (!Valid(text))
    return false;
  const std::vector<std::string> found = split(text, "/");
  this->parts.assign(found.begin(), found.end());
  return true;
}

URIQuery::URIQuery(const std::string &text)
{
  if (!this->Parse(text))
    warn_of("URIQuery", text);
}
std::string URIQuery::Str(const std::string &delimiter) const
{
  std::string text;
  for (const auto &value : this->values)
    text += (text.empty() ? "?" : delimiter) + value.first + "=" + value.second;
  return text;
}
bool URIQuery::Valid(const std::string &text)
{
  return URIQuery().Parse(text);
}
bool URIQuery::Parse(const std::string &text)
{
  std::map<std::string, std::string> found;
  if (!text.empty() && (text.rfind('?') != 0 || text.find(' ') != std::string::npos))
    return false;
  for (const std::string &pair : split(text.substr(text.empty() ? 0 : 1), "&"))
  {
    const std::vector<std::string> halves = split(pair, "=");
    if (halves.size() != 2)
      return false;
    found.insert({halves[0], halves[1]});
  }
  this->values = found;
  return true;
}

URI::URI(const std::string &text)
{
  if (!this->Parse(text))
    warn_of("URI", text);
}
std::string URI::Str() const
{
  return (this->scheme.empty() ? "" : this->scheme + "://") + this->path.Str() + this->query.Str();
}
bool URI::Valid(const std::string &text)
{
  return URI().Parse(text);
}
bool URI::Parse(const std::string &text)
{
  const std::size_t colon = text.find("://");
  if (colon == 0 || colon == std::string::npos)
    return false;
  const std::size_t start = colon + 3, question = std::min(text.find('?', start), text.size());
  URI found;
  found.scheme = text.substr(0, colon);
  if (!found.path.Parse(text.substr(start, question - start)) || !found.query.Parse(text.substr(question)))
    return false;
  *this = found;
  return true;
}

}  // namespace common

namespace physics {

common::URI World::URI() const
{
  common::URI uri;
  uri.SetScheme("data");
  uri.Path() /= "world";
  uri.Path() /= this->Name();
  return uri;
}
common::URI Base::URI() const
{
  static const std::pair<EntityType, const char *> KINDS[] = {
      {MODEL, "model"}, {LINK, "link"}, {COLLISION, "collision"}, {JOINT, "joint"}, {LIGHT, "light"}, {SHAPE, "shape"}};
  const char *kind = "entity";
  for (const auto &one : KINDS)
    if (this->HasType(one.first))
      kind = one.second;
  const BasePtr parent = this->GetParent();
  common::URI uri = parent && parent->HasType(ENTITY) ? parent->URI() : this->GetWorld()->URI();
  uri.Path() /= kind;
  uri.Path() /= this->GetName();
  return uri;
}

}  // namespace physics

namespace util {

IntrospectionManager::IntrospectionManager()
{
  std::random_device random;
  std::uniform_int_distribution<int> letter('a', 'z');
  std::generate_n(std::back_inserter(this->id), 10, [&] { return static_cast<char>(letter(random)); });
}
IntrospectionManager *IntrospectionManager::Instance()
{
  static IntrospectionManager one;
  return &one;
}
bool IntrospectionManager::Add(const std::string &item)
{
  std::lock_guard<std::mutex> lock(this->mutex);
  if (!this->items.insert(item).second)
  {
    gzwarn << "Item [" << item << "] already registered" << std::endl;
    return false;
  }
  return true;
}
bool IntrospectionManager::Unregister(const std::string &item)
{
  std::lock_guard<std::mutex> lock(this->mutex);
  if (this->items.erase(item) == 0)
  {
    gzwarn << "Item [" << item << "] is not registered" << std::endl;
    return false;
  }
  return true;
}
void IntrospectionManager::Clear()
{
  std::lock_guard<std::mutex> lock(this->mutex);
  this->items.clear();
}
std::set<std::string> IntrospectionManager::Items() const
{
  std::lock_guard<std::mutex> lock(this->mutex);
  return this->items;
}

}  // namespace util
}  // namespace gazebo
