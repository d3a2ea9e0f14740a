// The sketch's board on the host, with a model of motors and wheels, in a time that its test tells. It reads requests of a
// line each, "MILLISECONDS HEX-BYTES" or a change of the model, and answers each with "HEX-BYTES AHEAD LEFT TURN X Y
// HEADING": what the board sent, and how the model moves (m/s, rad/s, m, rad).
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <string>

#include "../../sketch/board.h"

namespace {

constexpr float kTimeConstant = 0.06f;  // s: that of a motor
constexpr uint8_t kWheels = 4;

struct Model : jde::Io {
  jde::Settings settings;
  double counted[kWheels] = {};  // m, by the encoders
  float speeds[kWheels] = {}, duties[kWheels] = {};
  double x = 0, y = 0, heading = 0;
  jde::Twist twist = {0, 0, 0};
  uint32_t offset = 0;      // of the counts
  bool blocked = false;     // its wheels do not turn
  bool reversed = false;    // its encoders count backwards
  bool dead = false;        // the left one counts nothing
  bool is_full = false;     // its line has no room
  bool racing = false;      // its motors have the full voltage, whatever the board says
  std::string front, sent;

  int32_t ticks(uint8_t wheel) override {
    return (int32_t)(uint32_t)((int64_t)floor(counted[wheel] * settings.ticks_per_metre) + offset);
  }
  void drive(uint8_t wheel, float duty) override { duties[wheel] = duty; }
  void sense(jde::Senses &senses) override {
    senses.front = front.c_str();
    senses.battery = 11.7f;
    senses.imu = true;
    senses.gyro[2] = twist.turn;
    senses.acc[2] = 9.81f;
  }
  bool send(const char *line, size_t size) override {
    if (is_full) return false;
    sent.append(line, size);
    return true;
  }

  void step(float seconds) {
    for (uint8_t i = 0; i < jde::wheels_of(settings.kind); i++) {
      // A motor has less than its voltage promises, as real ones do: the controller has to add it.
      const float goal = blocked ? 0 : (racing ? settings.full : duties[i] * settings.full * 0.85f);
      speeds[i] = blocked ? 0 : speeds[i] + (goal - speeds[i]) * (1 - expf(-seconds / kTimeConstant));
      if (!dead || i != 0) counted[i] += (reversed ? -speeds[i] : speeds[i]) * seconds;
    }
    twist = jde::base_speed(settings.kind, settings.track, speeds);
    heading += twist.turn * seconds / 2;
    x += (twist.ahead * cos(heading) - twist.left * sin(heading)) * seconds;
    y += (twist.ahead * sin(heading) + twist.left * cos(heading)) * seconds;
    heading += twist.turn * seconds / 2;
  }
};

jde::Settings settings(bool mecanum, const char *serial) {
  jde::Settings s = {};
  s.kind = mecanum ? jde::kMecanum : jde::kDifferential;
  s.serial = serial;
  s.track = mecanum ? 0.40f : 0.23f;
  s.ticks_per_metre = 5200;
  s.speed = 0.5f;
  s.side = mecanum ? 0.4f : 0;
  s.turn = 2;
  s.acceleration = 0.8f;
  s.deceleration = 1.2f;
  s.turn_acceleration = 6;
  s.turn_deceleration = 9;
  s.lag = 0.08f;
  s.full = 1.0f;
  s.proportional = 1;
  s.integral = 8;
  s.correction = 0.3f;
  s.empty = 9.9f;
  s.charged = 12.6f;
  return s;
}

}  // namespace

// Arguments: the kind, the serial number, and the milliseconds and the counts at the start.
int main(int count, char **arguments) {
  if (count != 5) return 2;
  Model model;
  model.settings = settings(std::string(arguments[1]) == "mecanum", arguments[2]);
  uint32_t now = (uint32_t)strtoul(arguments[3], nullptr, 10);
  model.offset = (uint32_t)strtoul(arguments[4], nullptr, 10);
  model.front = "00";
  auto *board = new jde::Board(model.settings, model);
  board->begin(now);
  char line[1 << 16];
  while (fgets(line, sizeof line, stdin)) {
    const std::string request(line);
    if (request == "block\n") model.blocked = !model.blocked;
    if (request == "reverse\n") model.reversed = !model.reversed;
    if (request == "full\n") model.is_full = !model.is_full;
    if (request == "race\n") model.racing = !model.racing;
    if (request == "dead\n") model.dead = !model.dead;
    if (request == "push\n") {
      for (float &speed : model.speeds) speed = 0.3f;
    }
    if (request == "bump\n") model.front = "10";
    if (request == "reset\n") {
      delete board;
      board = new jde::Board(model.settings, model);
      for (double &way : model.counted) way = 0;
      for (float &duty : model.duties) duty = 0;
      now = 3;
      board->begin(now);
    }
    char *end = line;
    unsigned long milliseconds = strtoul(line, &end, 10);
    if (end != line && *end == ' ') {
      for (end++; end[0] > ' ' && end[1] > ' '; end += 2) {
        const char digits[3] = {end[0], end[1], 0};
        board->receive((char)strtoul(digits, nullptr, 16), now);
      }
    }
    board->poll(now);
    for (; milliseconds > 0; milliseconds--) {
      now++;
      model.step(0.001f);
      board->poll(now);
    }
    for (const char byte : model.sent) printf("%02x", (unsigned)(unsigned char)byte);
    model.sent.clear();
    printf(" %.6f %.6f %.6f %.6f %.6f %.6f\n", (double)model.twist.ahead, (double)model.twist.left, (double)model.twist.turn,
           model.x, model.y, model.heading);
    fflush(stdout);
  }
  delete board;
  return 0;
}
