// A whole submission in C++ with the standard library alone: waits until the panel changes, then drives in a circle,
// and says by its encoders where it is.
#include <arpa/inet.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <iostream>

#include "msgpack.hpp"

using msgpack::Reader;
using msgpack::Value;
using msgpack::Writer;

// A message: its length in four bytes, big-endian, and then the msgpack.
class Connection {
 public:
  explicit Connection(const char* path) : end_(socket(AF_UNIX, SOCK_STREAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path, sizeof(address.sun_path) - 1);
    if (connect(end_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 0) throw std::runtime_error("no socket");
  }
  void send(const Writer& message) {
    const uint32_t length = htonl(message.bytes.size());
    const std::string whole = std::string(reinterpret_cast<const char*>(&length), 4) + message.bytes;
    for (size_t sent = 0; sent < whole.size();) {
      const ssize_t count = write(end_, whole.data() + sent, whole.size() - sent);
      if (count <= 0) throw std::runtime_error("the other end is gone");
      sent += count;
    }
  }
  bool receive(Value& message) {  // false when the run is over
    std::string length;
    if (!read(length, 4)) return false;
    uint32_t count;
    std::memcpy(&count, length.data(), 4);
    std::string body;
    if (!read(body, ntohl(count))) return false;
    message = Reader(body).read();
    return true;
  }

 private:
  bool read(std::string& into, size_t count) {
    into.resize(count);
    for (size_t have = 0; have < count;) {
      const ssize_t got = ::read(end_, &into[have], count - have);
      if (got <= 0) return false;
      have += got;
    }
    return true;
  }
  int end_;
};

// The pictures lie in a file beside the messages, each where its observation says.
class Pictures {
 public:
  explicit Pictures(const char* path) {
    const int file = open(path, O_RDONLY);
    struct stat about;
    if (file < 0 || fstat(file, &about) != 0) throw std::runtime_error("no pictures");
    bytes_ = static_cast<const uint8_t*>(mmap(nullptr, about.st_size, PROT_READ, MAP_SHARED, file, 0));
  }
  double mean_green(const Value& place) const {  // over the upper half, where the panel is
    const size_t pixels = place["width"].number * place["height"].number / 2;
    const uint8_t* rgb = bytes_ + static_cast<size_t>(place["offset"].number);
    double sum = 0;
    for (size_t k = 0; k < pixels; ++k) sum += rgb[3 * k + 1] - 0.5 * rgb[3 * k] - 0.5 * rgb[3 * k + 2];
    return sum / pixels;
  }

 private:
  const uint8_t* bytes_;
};

class Driver {
 public:
  explicit Driver(const Value& mission)
      : x_(mission["start_pose"]["x_m"].number),
        y_(mission["start_pose"]["y_m"].number),
        yaw_(mission["start_pose"]["yaw_rad"].number),
        separation_m_(mission["robot"]["wheel_separation_m"].number),
        tick_m_(2 * M_PI * mission["robot"]["wheel_radius_m"].number / mission["robot"]["encoder_ticks_per_turn"].number) {}

  void look(const Value& observation, const Pictures& pictures) {
    const auto& places = observation["pictures"].map;
    const auto panel = places.find("panel");
    if (panel != places.end()) {
      const double green = pictures.mean_green(panel->second);
      if (!has_looked_) first_green_ = green;
      has_looked_ = true;
      if (std::abs(green - first_green_) > 0.25) go_ = true;
    }
    const auto& left = observation["left_ticks"].list;
    const auto& right = observation["right_ticks"].list;
    for (size_t k = 0; k < left.size(); ++k) roll(left[k].number, right[k].number);
  }

  Writer command(const Value& observation) const {
    Writer out;
    out.map(3).text("type").text("command").text("step").integer(observation["step"].number).text("command").map(3);
    out.text("v_mps").number(go_ ? 0.5 : 0.0).text("omega_radps").number(go_ ? 0.2 : 0.0);
    out.text("pose_world_robot").map(3);
    out.text("x_m").number(x_).text("y_m").number(y_).text("yaw_rad").number(yaw_);
    return out;
  }

 private:
  void roll(double left, double right) {
    const double left_m = (left - left_) * tick_m_, right_m = (right - right_) * tick_m_;
    const double turn = (right_m - left_m) / separation_m_;
    x_ += (left_m + right_m) / 2 * std::cos(yaw_ + turn / 2);
    y_ += (left_m + right_m) / 2 * std::sin(yaw_ + turn / 2);
    yaw_ = std::remainder(yaw_ + turn, 2 * M_PI);
    left_ = left;
    right_ = right;
  }

  double x_, y_, yaw_, separation_m_, tick_m_;
  double left_ = 0, right_ = 0, first_green_ = 0;
  bool has_looked_ = false, go_ = false;
};

int main() try {
  Connection connection(std::getenv("ADC_BENCH_SOCKET"));
  const Pictures pictures(std::getenv("ADC_BENCH_PICTURES"));
  connection.send(Writer().map(2).text("type").text("hello").text("protocol").integer(1));
  Value message;
  if (!connection.receive(message)) return 1;
  Driver driver(message["mission"]);
  connection.send(Writer().map(1).text("type").text("ready"));
  while (connection.receive(message)) {
    driver.look(message, pictures);
    connection.send(driver.command(message));
  }
} catch (const std::exception& error) {
  std::cerr << error.what() << "\n";
  return 1;
}
