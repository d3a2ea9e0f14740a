// The commands of the protocol, read from lines. It refuses what is not exactly one. It knows no Arduino.
#pragma once

#include "line.h"

namespace jde {

struct Command {
  enum Kind : uint8_t { kBad, kHello, kStop, kVelocity };
  Kind kind = kBad;
  uint16_t number = 0;                 // of a greeting or a velocity
  int32_t ahead = 0, left = 0, turn = 0;  // mm/s, mm/s, mrad/s
};

// Reads a number of at most six digits, after one space. Moves `text` behind it.
inline bool read_number(const char *&text, int32_t &value) {
  if (*text != ' ') return false;
  text++;
  const bool negative = *text == '-';
  if (negative) text++;
  uint8_t digits = 0;
  value = 0;
  while (*text >= '0' && *text <= '9') {
    if (++digits > 6) return false;
    value = value * 10 + (*text++ - '0');
  }
  if (negative) value = -value;
  return digits > 0;
}

// Reads the line of a reader. "?" and "stop" are also taken without a checksum, from a person at a terminal: neither
// moves anything.
inline Command read_command(LineReader &reader) {
  Command command;
  const bool is_right = reader.check();
  const char *text = reader.text();
  int32_t number = 0;
  if (strcmp(text, "stop") == 0) {
    command.kind = Command::kStop;
  } else if (strcmp(text, "?") == 0) {
    command.kind = Command::kHello;
  } else if (!is_right) {
    return command;
  } else if (*text == '?') {
    if (read_number(++text, number) && !*text && number >= 0 && number <= 65535) {
      command.kind = Command::kHello;
      command.number = (uint16_t)number;
    }
  } else if (*text == 'v') {
    text++;
    if (read_number(text, number) && number >= 0 && number <= 65535 && read_number(text, command.ahead) &&
        read_number(text, command.left) && read_number(text, command.turn) && !*text) {
      command.kind = Command::kVelocity;
      command.number = (uint16_t)number;
    }
  }
  return command;
}

}  // namespace jde
