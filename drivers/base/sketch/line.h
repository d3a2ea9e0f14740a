// Lines of the protocol (docs/drivers/base.md): a text, '*', four hexadecimal digits, a line feed. It knows no Arduino.
#pragma once

#include <stddef.h>
#include <stdint.h>
#include <string.h>

namespace jde {

// CRC-16 with the polynomial 0x1021, from 0xFFFF ("CRC-16/IBM-3740"): that of "123456789" is 29B1.
inline uint16_t checksum(const char *text, size_t size) {
  uint16_t crc = 0xffff;
  for (size_t i = 0; i < size; i++) {
    crc ^= (uint16_t)((uint16_t)(uint8_t)text[i] << 8);
    for (uint8_t bit = 0; bit < 8; bit++) crc = (uint16_t)((crc & 0x8000) ? (crc << 1) ^ 0x1021 : crc << 1);
  }
  return crc;
}

inline char hex_digit(uint8_t value) { return (char)(value < 10 ? '0' + value : 'A' + value - 10); }

// Collects bytes until a line is whole. A line that is too long is discarded up to its end.
class LineReader {
 public:
  static const size_t kSize = 64;

  // Takes a byte. Returns whether a line is whole; `text` has it until the next byte.
  bool receive(char byte) {
    if (byte == '\n' || byte == '\r') {
      text_[size_] = 0;
      length_ = size_;
      size_ = 0;
      too_long_ = overflow_;
      overflow_ = false;
      return length_ > 0 || too_long_;
    }
    if (size_ < kSize - 1) {
      text_[size_++] = byte;
    } else {
      overflow_ = true;
    }
    return false;
  }

  // Removes the checksum. Returns whether it is right, as it is not in a line that is too long.
  bool check() {
    if (too_long_ || length_ < 5 || text_[length_ - 5] != '*') return false;
    const size_t size = length_ - 5;
    const uint16_t crc = checksum(text_, size);
    for (uint8_t i = 0; i < 4; i++) {
      if (text_[size + 1 + i] != hex_digit((uint8_t)((crc >> (12 - 4 * i)) & 15))) return false;
    }
    text_[size] = 0;
    return true;
  }

  const char *text() const { return text_; }

 private:
  char text_[kSize];
  size_t size_ = 0;
  size_t length_ = 0;
  bool overflow_ = false;
  bool too_long_ = false;
};

// Composes a line. What does not fit makes it empty: half a line is not sent.
class LineWriter {
 public:
  static const size_t kSize = 320;

  void word(const char *text) {
    while (*text) put(*text++);
  }

  void number(int32_t value) {
    if (value < 0) put('-');
    digits(value < 0 ? 0u - (uint32_t)value : (uint32_t)value);
  }

  // Appends " key=value".
  void field(const char *key, int32_t value) {
    this->key(key);
    number(value);
  }

  void count(const char *key, uint32_t value) {
    this->key(key);
    digits(value);
  }

  void key(const char *key) {
    put(' ');
    word(key);
    put('=');
  }

  void put(char byte) {
    if (size_ < kSize - 6) {
      text_[size_++] = byte;
    } else {
      overflow_ = true;
    }
  }

  // Ends the line with its checksum. Returns its size.
  size_t end() {
    if (overflow_) return 0;
    const uint16_t crc = checksum(text_, size_);
    text_[size_++] = '*';
    for (uint8_t i = 0; i < 4; i++) text_[size_++] = hex_digit((uint8_t)((crc >> (12 - 4 * i)) & 15));
    text_[size_++] = '\n';
    return size_;
  }

  const char *text() const { return text_; }

 private:
  void digits(uint32_t value) {
    char reversed[10];
    uint8_t count = 0;
    do {
      reversed[count++] = (char)('0' + value % 10);
      value /= 10;
    } while (value);
    while (count) put(reversed[--count]);
  }

  char text_[kSize];
  size_t size_ = 0;
  bool overflow_ = false;
};

}  // namespace jde
