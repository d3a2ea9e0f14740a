// The programs of ROS 2 with which the benches compare jde. They use rclcpp as its tutorials do. Each role ends when its
// standard input closes, and prints "ready" first. Times are of the wall clock, ns.
//
//   talk (TOPIC BYTES EVERY_MS PHASE_MS)...  publishes pictures whose first bytes are the time and a number; without a
//                                            pause if EVERY_MS is 0
//   listen TOPIC...                          prints a line for each picture at the end: topic, sent, arrived, number
//   count (TOPIC TYPE)...                    prints the number of messages of each topic at the end
//   drive SOURCE SINK COUNT                  publishes velocities, and prints how long each takes to the other topic
//   nodes COUNT                              is so many nodes, with a publication and a subscription each
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <poll.h>
#include <unistd.h>

#include "geometry_msgs/msg/twist.hpp"
#include "rclcpp/rclcpp.hpp"
#include "sensor_msgs/msg/image.hpp"

using geometry_msgs::msg::Twist;
using sensor_msgs::msg::Image;

static int64_t now() {
  const auto time = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time).count();
}

// Whether the standard input has closed.
static bool has_ended() {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  char byte;
  return poll(&input, 1, 0) > 0 && read(STDIN_FILENO, &byte, 1) <= 0;
}

static void announce() {
  std::puts("ready");
  std::fflush(stdout);
}

// Spins the nodes until the standard input closes.
static void spin(const std::vector<std::shared_ptr<rclcpp::Node>> & nodes) {
  rclcpp::executors::SingleThreadedExecutor executor;
  for (const auto & node : nodes) {
    executor.add_node(node);
  }
  std::thread waiting([&executor] {
    char byte;
    while (read(STDIN_FILENO, &byte, 1) > 0) {
    }
    executor.cancel();
  });
  announce();
  executor.spin();
  waiting.join();
}

struct Talk {
  rclcpp::Publisher<Image>::SharedPtr publisher;
  Image message;
  int64_t every;
  int64_t next;
  uint64_t number = 0;
};

static int talk(const std::shared_ptr<rclcpp::Node> & node, const std::vector<std::string> & arguments) {
  std::vector<Talk> talks;
  for (size_t at = 0; at + 3 < arguments.size(); at += 4) {
    Talk one;
    one.publisher = node->create_publisher<Image>(arguments[at], rclcpp::SensorDataQoS());
    const auto bytes = std::stoul(arguments[at + 1]);
    one.message.data.resize(bytes);
    one.message.height = 1;
    one.message.width = one.message.step = bytes;
    one.message.encoding = "mono8";
    one.every = std::stoll(arguments[at + 2]) * 1000000;
    const auto phase = std::stoll(arguments[at + 3]) * 1000000;
    one.next = one.every ? now() / one.every * one.every + one.every + phase : 0;
    talks.push_back(one);
  }
  announce();
  while (!has_ended()) {
    auto & due = *std::min_element(
      talks.begin(), talks.end(), [](const Talk & a, const Talk & b) {return a.next < b.next;});
    // Short pauses, so that the end is noticed.
    const auto pause = std::min<int64_t>(due.next - now(), 100000000);
    if (pause > 0) {
      std::this_thread::sleep_for(std::chrono::nanoseconds(pause));
    }
    if (due.next > now()) {
      continue;
    }
    const int64_t sent = now();
    due.number += 1;
    std::memcpy(due.message.data.data(), &sent, 8);
    std::memcpy(due.message.data.data() + 8, &due.number, 8);
    due.publisher->publish(due.message);
    due.next += due.every;
  }
  return 0;
}

struct Arrival {
  size_t topic;
  int64_t sent;
  int64_t arrived;
  uint64_t number;
};

static int listen(const std::shared_ptr<rclcpp::Node> & node, const std::vector<std::string> & topics) {
  std::vector<Arrival> arrivals;
  arrivals.reserve(1 << 20);
  std::vector<rclcpp::Subscription<Image>::SharedPtr> subscriptions;
  for (size_t topic = 0; topic < topics.size(); topic++) {
    subscriptions.push_back(node->create_subscription<Image>(
        topics[topic], rclcpp::SensorDataQoS(), [&arrivals, topic](Image::ConstSharedPtr message) {
          Arrival arrival{topic, 0, now(), 0};
          if (message->data.size() >= 16) {
            std::memcpy(&arrival.sent, message->data.data(), 8);
            std::memcpy(&arrival.number, message->data.data() + 8, 8);
            arrivals.push_back(arrival);
          }
        }));
  }
  spin({node});
  for (const auto & one : arrivals) {
    std::printf(
      "%s %lld %lld %llu\n", topics[one.topic].c_str(), static_cast<long long>(one.sent),
      static_cast<long long>(one.arrived), static_cast<unsigned long long>(one.number));
  }
  return 0;
}

static int count(const std::shared_ptr<rclcpp::Node> & node, const std::vector<std::string> & arguments) {
  std::vector<uint64_t> counts(arguments.size() / 2);
  std::vector<rclcpp::GenericSubscription::SharedPtr> subscriptions;
  for (size_t topic = 0; topic < counts.size(); topic++) {
    subscriptions.push_back(node->create_generic_subscription(
        arguments[2 * topic], arguments[2 * topic + 1], rclcpp::SensorDataQoS(),
        [&counts, topic](std::shared_ptr<rclcpp::SerializedMessage>) {counts[topic] += 1;}));
  }
  spin({node});
  for (const auto number : counts) {
    std::printf("%llu\n", static_cast<unsigned long long>(number));
  }
  return 0;
}

static int drive(const std::shared_ptr<rclcpp::Node> & node, const std::vector<std::string> & arguments) {
  const int count = std::stoi(arguments[2]);
  std::mutex lock;
  std::map<double, int64_t> sent;
  std::vector<int64_t> times;
  auto subscription = node->create_subscription<Twist>(
    arguments[1], 10, [&](Twist::ConstSharedPtr message) {
      std::lock_guard<std::mutex> guard(lock);
      const auto found = sent.find(message->linear.x);
      if (found != sent.end()) {
        times.push_back(now() - found->second);
        sent.erase(found);
      }
    });
  auto publisher = node->create_publisher<Twist>(arguments[0], 10);
  rclcpp::executors::SingleThreadedExecutor executor;
  executor.add_node(node);
  std::thread spinning([&executor] {executor.spin();});
  announce();
  uint64_t random = 1;
  for (int number = 0; number < count && !has_ended(); number++) {
    Twist message;
    message.linear.x = 0.1 + number * 1e-5;
    {
      std::lock_guard<std::mutex> guard(lock);
      sent[message.linear.x] = now();
    }
    publisher->publish(message);
    // Not in step with any period.
    random = random * 6364136223846793005u + 1442695040888963407u;
    std::this_thread::sleep_for(std::chrono::microseconds(50000 + (random >> 33) % 20000));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  executor.cancel();
  spinning.join();
  for (const auto time : times) {
    std::printf("%lld\n", static_cast<long long>(time));
  }
  return 0;
}

static int nodes(int count) {
  std::vector<std::shared_ptr<rclcpp::Node>> nodes;
  std::vector<std::shared_ptr<void>> entities;
  for (int number = 0; number < count; number++) {
    const auto name = "crowd" + std::to_string(number);
    auto node = std::make_shared<rclcpp::Node>(name);
    entities.push_back(node->create_publisher<Twist>(name + "/out", 10));
    entities.push_back(node->create_subscription<Twist>(name + "/in", 10, [](Twist::ConstSharedPtr) {}));
    nodes.push_back(node);
  }
  spin(nodes);
  return 0;
}

int main(int length, char ** values) {
  rclcpp::init(length, values);
  const std::string role = length > 1 ? values[1] : "";
  const std::vector<std::string> arguments(values + std::min(length, 2), values + length);
  int status = 2;
  if (role == "nodes" && arguments.size() == 1) {
    status = nodes(std::stoi(arguments[0]));
  } else if (role == "talk" && !arguments.empty() && arguments.size() % 4 == 0) {
    status = talk(std::make_shared<rclcpp::Node>("talk"), arguments);
  } else if (role == "listen" && !arguments.empty()) {
    status = listen(std::make_shared<rclcpp::Node>("listen"), arguments);
  } else if (role == "count" && !arguments.empty() && arguments.size() % 2 == 0) {
    status = count(std::make_shared<rclcpp::Node>("count"), arguments);
  } else if (role == "drive" && arguments.size() == 3) {
    status = drive(std::make_shared<rclcpp::Node>("drive"), arguments);
  } else {
    std::fprintf(stderr, "the roles are: talk, listen, count, drive, nodes\n");
  }
  rclcpp::shutdown();
  return status;
}
