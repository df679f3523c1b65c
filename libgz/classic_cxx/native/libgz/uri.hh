/* URIs of what is in a world: data://world/default/model/box?p=pose3d/world_pose. License: Apache License 2.0. */
#ifndef LIBGZ_URI_HH
#define LIBGZ_URI_HH
#include <list>
#include <map>

#include "gazebo/libgz/base.hh"

namespace gazebo {
namespace common {

class GAZEBO_VISIBLE URIPath
{
 public:
  URIPath() {}
  explicit URIPath(const std::string &text);
  void Clear() { this->parts.clear(); }
  void PushFront(const std::string &part) { this->parts.push_front(part); }
  void PushBack(const std::string &part) { this->parts.push_back(part); }
  const URIPath &operator/=(const std::string &part)
  {
    this->PushBack(part);
    return *this;
  }
  const URIPath operator/(const std::string &part) const { return URIPath(*this) /= part; }
  bool operator==(const URIPath &other) const { return this->parts == other.parts; }
  std::string Str(const std::string &delimiter = "/") const;
  bool Valid() const { return Valid(this->Str()); }
  static bool Valid(const std::string &text);
  /* Takes the value of a text; false, without a change, if that is invalid. */
  bool Parse(const std::string &text);
  /* Whether another path begins this one. */
  bool Contains(const URIPath &other) const { return this->Str().rfind(other.Str(), 0) == 0; }

 private:
  std::list<std::string> parts;
};

class GAZEBO_VISIBLE URIQuery
{
 public:
  URIQuery() {}
  explicit URIQuery(const std::string &text);
  void Clear() { this->values.clear(); }
  void Insert(const std::string &key, const std::string &value) { this->values.insert({key, value}); }
  bool operator==(const URIQuery &other) const { return this->values == other.values; }
  std::string Str(const std::string &delimiter = "&") const;
  bool Valid() const { return Valid(this->Str()); }
  static bool Valid(const std::string &text);
  bool Parse(const std::string &text);

 private:
  std::map<std::string, std::string> values;
};

class GAZEBO_VISIBLE URI
{
 public:
  URI() {}
  explicit URI(const std::string &text);
  std::string Str() const;
  void Clear() { *this = URI(); }
  std::string Scheme() const { return this->scheme; }
  void SetScheme(const std::string &name) { this->scheme = name; }
  URIPath &Path() { return this->path; }
  const URIPath &Path() const { return this->path; }
  URIQuery &Query() { return this->query; }
  const URIQuery &Query() const { return this->query; }
  bool operator==(const URI &other) const { return this->Str() == other.Str(); }
  bool Valid() const { return Valid(this->Str()); }
  static bool Valid(const std::string &text);
  bool Parse(const std::string &text);

 private:
  std::string scheme;
  URIPath path;
  URIQuery query;
};

}  // namespace common
}  // namespace gazebo
#endif
