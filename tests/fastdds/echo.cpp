// A peer on another DDS implementation: eProsima's Fast-DDS, with Fast-CDR.
//
// It reads JointState, String and Twist on `rt/joint_states`, `rt/robot_description` and
// `rt/cmd_vel`, decodes each message field by field, encodes it anew and publishes it on the same
// topic with `_echo` behind. It keeps to the loopback interface. The only argument is the domain;
// it ends when its standard input does.

#include <fastcdr/Cdr.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include <array>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

using namespace eprosima::fastdds::dds;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
using eprosima::fastrtps::rtps::InstanceHandle_t;
using eprosima::fastrtps::rtps::IPLocator;
using eprosima::fastrtps::rtps::Locator_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;

struct Text {
  static constexpr const char* name = "std_msgs::msg::dds_::String_";
  std::string data;
  void write(Cdr& out) const { out << data; }
  void read(Cdr& in) { in >> data; }
};

struct Twist {
  static constexpr const char* name = "geometry_msgs::msg::dds_::Twist_";
  std::array<double, 6> numbers{};
  void write(Cdr& out) const {
    for (double x : numbers) out << x;
  }
  void read(Cdr& in) {
    for (double& x : numbers) in >> x;
  }
};

struct JointState {
  static constexpr const char* name = "sensor_msgs::msg::dds_::JointState_";
  int32_t sec = 0;
  uint32_t nanosec = 0;
  std::string frame_id;
  std::vector<std::string> names;
  std::vector<double> position, velocity, effort;
  void write(Cdr& out) const {
    out << sec << nanosec << frame_id << names << position << velocity << effort;
  }
  void read(Cdr& in) {
    in >> sec >> nanosec >> frame_id >> names >> position >> velocity >> effort;
  }
};

template <typename T>
class Type : public TopicDataType {
 public:
  Type() {
    setName(T::name);
    m_typeSize = 1 << 20;
    m_isGetKeyDefined = false;
  }
  bool serialize(void* data, SerializedPayload_t* payload) override {
    FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->max_size);
    Cdr out(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    payload->encapsulation = CDR_LE;
    out.serialize_encapsulation();
    static_cast<T*>(data)->write(out);
    payload->length = static_cast<uint32_t>(out.getSerializedDataLength());
    return true;
  }
  bool deserialize(SerializedPayload_t* payload, void* data) override {
    FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->length);
    Cdr in(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    in.read_encapsulation();
    static_cast<T*>(data)->read(in);
    return true;
  }
  std::function<uint32_t()> getSerializedSizeProvider(void*) override {
    return [this] { return m_typeSize; };
  }
  void* createData() override { return new T(); }
  void deleteData(void* data) override { delete static_cast<T*>(data); }
  bool getKey(void*, InstanceHandle_t*, bool) override { return false; }
};

template <typename T>
class Echo : public DataReaderListener {
 public:
  Echo(DomainParticipant* participant, Publisher* publisher, Subscriber* subscriber,
       const std::string& topic, bool latched) {
    TypeSupport type(new Type<T>());
    type.register_type(participant);
    DataWriterQos out;
    DataReaderQos in;
    out.reliability().kind = in.reliability().kind = RELIABLE_RELIABILITY_QOS;
    out.durability().kind = in.durability().kind =
        latched ? TRANSIENT_LOCAL_DURABILITY_QOS : VOLATILE_DURABILITY_QOS;
    out.history().depth = in.history().depth = latched ? 1 : 100;
    out.endpoint().history_memory_policy = in.endpoint().history_memory_policy =
        eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    writer_ = publisher->create_datawriter(
        participant->create_topic(topic + "_echo", T::name, TOPIC_QOS_DEFAULT), out);
    subscriber->create_datareader(
        participant->create_topic(topic, T::name, TOPIC_QOS_DEFAULT), in, this);
  }
  void on_data_available(DataReader* reader) override {
    T message;
    SampleInfo info;
    while (reader->take_next_sample(&message, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) writer_->write(&message);
    }
  }

 private:
  DataWriter* writer_ = nullptr;
};

int main(int argc, char** argv) {
  const int domain = argc > 1 ? std::atoi(argv[1]) : 0;
  DomainParticipantQos qos;
  qos.name("fastdds_echo");
  qos.transport().use_builtin_transports = false;
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.push_back("127.0.0.1");
  qos.transport().user_transports.push_back(udp);
  auto& builtin = qos.wire_protocol().builtin;
  Locator_t here;
  IPLocator::setIPv4(here, "127.0.0.1");
  builtin.metatrafficUnicastLocatorList.push_back(here);  // and so no multicast
  for (int index = 0; index < 32; ++index) {
    Locator_t peer;
    IPLocator::setIPv4(peer, "127.0.0.1");
    peer.port = 7400 + 250 * domain + 10 + 2 * index;
    builtin.initialPeersList.push_back(peer);
  }
  auto* participant =
      DomainParticipantFactory::get_instance()->create_participant(domain, qos);
  if (participant == nullptr) return 1;
  auto* publisher = participant->create_publisher(PUBLISHER_QOS_DEFAULT);
  auto* subscriber = participant->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
  Echo<JointState> joints(participant, publisher, subscriber, "rt/joint_states", false);
  Echo<Text> description(participant, publisher, subscriber, "rt/robot_description", true);
  Echo<Twist> velocity(participant, publisher, subscriber, "rt/cmd_vel", false);
  std::cout << "ready" << std::endl;
  std::string line;
  while (std::getline(std::cin, line)) {
  }
  // Endpoints still point to the listeners above: the process ends before they do.
  std::quick_exit(0);
}
