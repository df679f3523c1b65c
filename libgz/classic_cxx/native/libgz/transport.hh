/* Namespace gazebo::transport: nodes, publishers, subscribers. License: Apache License 2.0. */
#ifndef LIBGZ_TRANSPORT_HH
#define LIBGZ_TRANSPORT_HH
#include "gazebo/libgz/msgs.hh"

namespace gazebo {
namespace transport {
class Node;
class Publisher;
class Subscriber;
class Connection;
class Publication;
class PublicationTransport;
class SubscriptionTransport;
class CallbackHelper;
typedef boost::shared_ptr<google::protobuf::Message> MessagePtr;
typedef boost::shared_ptr<Node> NodePtr;
typedef boost::shared_ptr<Publisher> PublisherPtr;
typedef boost::shared_ptr<Subscriber> SubscriberPtr;
typedef boost::shared_ptr<Connection> ConnectionPtr;
typedef boost::shared_ptr<Publication> PublicationPtr;
typedef boost::shared_ptr<PublicationTransport> PublicationTransportPtr;
typedef boost::shared_ptr<SubscriptionTransport> SubscriptionTransportPtr;
typedef boost::shared_ptr<CallbackHelper> CallbackHelperPtr;

class GAZEBO_VISIBLE Publisher : public libgz::Object, public boost::enable_shared_from_this<Publisher>
{
 public:
  explicit Publisher(libgz::Adopt view) : Object(view) {}
  bool HasConnections() const;
  void WaitForConnection() const;
  bool WaitForConnection(const common::Time &timeout) const;
  void Publish(const google::protobuf::Message &message, bool block = false);
  template <typename M>
  void Publish(M message, bool block = false)
  {
    const google::protobuf::Message &plain = message;
    this->Publish(plain, block);
  }
  unsigned int GetRemoteSubscriptionCount() { return this->HasConnections(); }
  unsigned int GetOutgoingCount() const;
  std::string GetTopic() const;
  std::string GetMsgType() const;
  void SendMessage();
  void Fini();
  uint32_t Id() const { return this->id; }

 private:
  uint32_t id = 0;
};

class GAZEBO_VISIBLE Subscriber : public libgz::Object
{
 public:
  explicit Subscriber(libgz::Adopt view) : Object(view) {}
  std::string GetTopic() const;
  void Unsubscribe() const;
};

class GAZEBO_VISIBLE SubscribeOptions
{
 public:
  std::string GetTopic() const { return this->topic; }
  NodePtr GetNode() const { return this->node; }
  bool GetLatching() const { return this->latching; }
  std::string topic;
  NodePtr node;
  bool latching = false;
};

class GAZEBO_VISIBLE Node : public libgz::Object, public boost::enable_shared_from_this<Node>
{
 public:
  Node();
  explicit Node(libgz::Adopt view) : Object(view) {}
  void Init(const std::string &space = "");
  bool TryInit(const common::Time &most = common::Time(1, 0));
  bool IsInitialized() const;
  void Fini();
  std::string GetTopicNamespace() const;
  std::string DecodeTopicName(const std::string &topic);
  std::string EncodeTopicName(const std::string &topic);
  unsigned int GetId() const;
  std::string GetMsgType(const std::string &topic) const;
  void ProcessPublishers() {}
  void ProcessIncoming() {}
  void Publish(const std::string &topic, const google::protobuf::Message &message);
  template <typename M>
  PublisherPtr Advertise(const std::string &topic, unsigned int queueLimit = 1000, double hzRate = 0)
  {
    return this->AdvertiseAs(M::default_instance(), topic, queueLimit, hzRate);
  }
  PublisherPtr Advertise(
      const std::string &topic, const std::string &type, unsigned int queueLimit = 1000, double hzRate = 0);

  template <typename M, typename T>
  SubscriberPtr Subscribe(const std::string &topic, void (T::*callback)(const boost::shared_ptr<M const> &),
      T *object, bool latching = false)
  {
    return this->SubscribeTo<M>(topic, [callback, object](const boost::shared_ptr<M const> &m) { (object->*callback)(m); },
        latching);
  }
  template <typename M>
  SubscriberPtr Subscribe(
      const std::string &topic, void (*callback)(const boost::shared_ptr<M const> &), bool latching = false)
  {
    return this->SubscribeTo<M>(topic, callback, latching);
  }
  template <typename T>
  SubscriberPtr Subscribe(
      const std::string &topic, void (T::*callback)(const std::string &), T *object, bool latching = false)
  {
    return this->SubscribeRaw(
        topic, nullptr, [callback, object](const std::string &data) { (object->*callback)(data); }, latching);
  }
  SubscriberPtr Subscribe(const std::string &topic, void (*callback)(const std::string &), bool latching = false)
  {
    return this->SubscribeRaw(topic, nullptr, callback, latching);
  }

 private:
  PublisherPtr AdvertiseAs(
      const google::protobuf::Message &type, const std::string &topic, unsigned int queueLimit, double hzRate);
  SubscriberPtr SubscribeRaw(const std::string &topic, const google::protobuf::Message *type,
      std::function<void(const std::string &)> callback, bool latching);
  template <typename M>
  SubscriberPtr SubscribeTo(
      const std::string &topic, std::function<void(const boost::shared_ptr<M const> &)> callback, bool latching)
  {
    return this->SubscribeRaw(
        topic, &M::default_instance(),
        [callback](const std::string &data) {
          boost::shared_ptr<M> message(new M);
          message->ParsePartialFromString(data);
          callback(message);
        },
        latching);
  }
};

/* What manages all topics: libgz's own manager serves plugins, which need none of this. */
class GAZEBO_VISIBLE TopicManager : public SingletonT<TopicManager>
{
 public:
  void GetTopicNamespaces(std::list<std::string> &names);
  std::vector<std::string> GetAdvertisedTopics(const std::string &type = "") const;
  void ConnectPubToSub(const std::string &, const SubscriptionTransportPtr) {}
  void PauseIncoming(bool) {}
  void ClearBuffers() {}
};

bool init(const std::string &host = "", unsigned int port = 0, uint32_t timeout = 30);
void run();
void stop();
void fini();
bool is_stopped();
void clear_buffers();
void pause_incoming(bool pause);
bool get_master_uri(std::string &host, unsigned int &port);
void get_topic_namespaces(std::list<std::string> &names);
bool waitForNamespaces(const gazebo::common::Time &most);
boost::shared_ptr<msgs::Response> request(const std::string &world, const std::string &request,
    const std::string &data = "", const common::Time &timeout = -1);
void requestNoReply(const std::string &world, const std::string &request, const std::string &data = "");
void requestNoReply(NodePtr node, const std::string &request, const std::string &data = "");
std::map<std::string, std::list<std::string>> getAdvertisedTopics();
std::list<std::string> getAdvertisedTopics(const std::string &type);
std::string getTopicMsgType(const std::string &topic);
void setMinimalComms(bool enabled);
bool getMinimalComms();
template <typename M>
void publish(const std::string &topic, const google::protobuf::Message &message)
{
  NodePtr node(new Node);
  node->Init();
  node->Advertise<M>(topic)->Publish(message);
}
}  // namespace transport
}  // namespace gazebo
#endif
