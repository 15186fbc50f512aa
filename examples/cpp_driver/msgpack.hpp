// As much of msgpack as the protocol needs: any message can be read; numbers, texts and maps can be written.
#pragma once
#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace msgpack {

struct Value {
  double number = 0;  // also true and false
  std::string text;   // also binary
  std::vector<Value> list;
  std::map<std::string, Value> map;
  bool is_nil = false;

  const Value& operator[](const std::string& key) const {
    auto found = map.find(key);
    if (found == map.end()) throw std::runtime_error("no field " + key);
    return found->second;
  }
};

class Reader {
 public:
  explicit Reader(const std::string& bytes) : bytes_(bytes) {}

  Value read() {
    Value value;
    const uint8_t head = static_cast<uint8_t>(take(1)[0]);
    if (head < 0x80) value.number = head;
    else if (head < 0x90) map(value, head & 0x0f);
    else if (head < 0xa0) list(value, head & 0x0f);
    else if (head < 0xc0) value.text = take(head & 0x1f);
    else if (head >= 0xe0) value.number = static_cast<int8_t>(head);
    else switch (head) {
      case 0xc0: value.is_nil = true; break;
      case 0xc2: case 0xc3: value.number = head & 1; break;
      case 0xc4: case 0xd9: value.text = take(integer(1)); break;
      case 0xc5: case 0xda: value.text = take(integer(2)); break;
      case 0xc6: case 0xdb: value.text = take(integer(4)); break;
      case 0xca: { const uint32_t bits = integer(4); float f; std::memcpy(&f, &bits, 4); value.number = f; break; }
      case 0xcb: { const uint64_t bits = integer(8); std::memcpy(&value.number, &bits, 8); break; }
      case 0xcc: value.number = integer(1); break;
      case 0xcd: value.number = integer(2); break;
      case 0xce: value.number = integer(4); break;
      case 0xcf: value.number = integer(8); break;
      case 0xd0: value.number = static_cast<int8_t>(integer(1)); break;
      case 0xd1: value.number = static_cast<int16_t>(integer(2)); break;
      case 0xd2: value.number = static_cast<int32_t>(integer(4)); break;
      case 0xd3: value.number = static_cast<int64_t>(integer(8)); break;
      case 0xdc: list(value, integer(2)); break;
      case 0xdd: list(value, integer(4)); break;
      case 0xde: map(value, integer(2)); break;
      case 0xdf: map(value, integer(4)); break;
      default: throw std::runtime_error("unknown msgpack head");
    }
    return value;
  }

 private:
  std::string take(size_t count) {
    if (at_ + count > bytes_.size()) throw std::runtime_error("a message that ends early");
    at_ += count;
    return bytes_.substr(at_ - count, count);
  }
  uint64_t integer(int count) {  // big-endian
    uint64_t value = 0;
    for (const char c : take(count)) value = value << 8 | static_cast<uint8_t>(c);
    return value;
  }
  void list(Value& value, size_t count) {
    while (count--) value.list.push_back(read());
  }
  void map(Value& value, size_t count) {
    while (count--) {
      const std::string key = read().text;
      value.map[key] = read();
    }
  }

  const std::string& bytes_;
  size_t at_ = 0;
};

class Writer {
 public:
  Writer& map(int fields) { bytes += static_cast<char>(0x80 | fields); return *this; }  // at most 15
  Writer& text(const std::string& text) {                                               // at most 31 bytes
    bytes += static_cast<char>(0xa0 | text.size());
    bytes += text;
    return *this;
  }
  Writer& integer(int64_t value) {
    bytes += static_cast<char>(0xd3);
    return big_endian(static_cast<uint64_t>(value));
  }
  Writer& number(double value) {
    uint64_t bits;
    std::memcpy(&bits, &value, 8);
    bytes += static_cast<char>(0xcb);
    return big_endian(bits);
  }
  std::string bytes;

 private:
  Writer& big_endian(uint64_t bits) {
    for (int shift = 56; shift >= 0; shift -= 8) bytes += static_cast<char>(bits >> shift & 0xff);
    return *this;
  }
};

}  // namespace msgpack
