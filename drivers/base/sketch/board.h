// The board of a base: it takes commands, controls its wheels, stops by its watchdog, and states what it senses. It knows
// no Arduino: `Io` is what the sketch, or a test, connects it to.
#pragma once

#include "command.h"
#include "drive.h"

namespace jde {

// What a person measures on a robot, and states.
struct Settings {
  Kind kind;
  const char *serial;    // the name of this very robot, without spaces
  float track;           // m: see wheel_speed
  float ticks_per_metre;
  float speed, side;     // m/s: the greatest, ahead and to the side (0 if it has none)
  float turn;            // rad/s
  float acceleration, deceleration;            // m/s2
  float turn_acceleration, turn_deceleration;  // rad/s2
  float lag;             // s: after this time its speed has 63 % of a step
  float full;            // m/s: the speed of a wheel at the full voltage
  float proportional, integral;  // the controller of a wheel: 1/(m/s), 1/m
  float correction;      // the greatest share of the voltage that the controller adds: see Wheel
  float empty, charged;  // V: those of its battery; 0 without one
};

// What it senses beside its wheels. A robot leaves out what it has not.
struct Senses {
  const char *front = nullptr;  // its bumpers from left to right, '0' or '1' each; at most 8
  const char *rear = nullptr;
  float battery = -1;           // V
  bool imu = false;
  float gyro[3] = {};           // rad/s
  float acc[3] = {};            // m/s2, 9.81 upwards at rest
};

class Io {
 public:
  virtual int32_t ticks(uint8_t wheel) = 0;            // forward motion counts up; it may wrap
  virtual void drive(uint8_t wheel, float duty) = 0;   // from -1 to 1
  virtual void sense(Senses &senses) = 0;
  virtual bool send(const char *line, size_t size) = 0;  // takes a line without waiting, or returns that it cannot now
};

class Board {
 public:
  static const uint16_t kPeriod = 20;     // ms between two lines of its state
  static const uint16_t kWatchdog = 300;  // ms without a valid command, after which it stops

  Board(const Settings &settings, Io &io) : settings_(settings), io_(io) {}

  // Call it first.
  void begin(uint32_t now) {
    for (uint8_t i = 0; i < wheels(); i++) ticks_[i] = io_.ticks(i);
    due_ = last_ = now;
    stand();
    greet(0);
  }

  // Call it with each byte that arrives.
  void receive(char byte, uint32_t now) {
    if (!reader_.receive(byte)) return;
    const Command command = read_command(reader_);
    switch (command.kind) {
      case Command::kBad:
        bad_++;
        break;
      case Command::kHello:
        stand();
        greet(command.number);
        break;
      case Command::kStop:
        stand();
        break;
      case Command::kVelocity:
        commanded_ = now;
        acknowledged_ = command.number;
        has_command_ = true;
        goal_ = {command.ahead / 1000.0f, settings_.side > 0 ? command.left / 1000.0f : 0, command.turn / 1000.0f};
        goal_ = within(goal_, settings_.speed, settings_.side, settings_.turn);
        if (is_zero(goal_) && stands()) stalled_ = false;
        break;
    }
  }

  // Call it as often as possible.
  void poll(uint32_t now) {
    if (has_command_ && now - commanded_ > kWatchdog) stand();
    if (has_greeting_ && hello(greeting_)) has_greeting_ = false;
    if ((int32_t)(now - due_) < 0) return;
    due_ += kPeriod;
    if ((int32_t)(now - due_) >= 0) due_ = now + kPeriod;
    const float step = (now - last_) / 1000.0f;
    last_ = now;
    if (step <= 0) return;
    control(step);
    state(now, step);
  }

 private:
  uint8_t wheels() const { return wheels_of(settings_.kind); }

  // No command is in force.
  void stand() {
    has_command_ = false;
    goal_ = {0, 0, 0};
  }

  // Whether its wheels stand, as far as they are measured.
  bool stands() const {
    for (uint8_t i = 0; i < wheels(); i++) {
      if (!Wheel::is_still(speeds_[i], settings_.full)) return false;
    }
    return true;
  }

  // It says what it is, as soon as there is room for that line.
  void greet(uint16_t number) {
    greeting_ = number;
    has_greeting_ = true;
  }

  void control(float step) {
    const Settings &s = settings_;
    const Twist goal = stalled_ ? Twist{0, 0, 0} : goal_;
    twist_.ahead = approach(twist_.ahead, goal.ahead, s.acceleration * step, s.deceleration * step);
    twist_.left = approach(twist_.left, goal.left, s.acceleration * step, s.deceleration * step);
    twist_.turn = approach(twist_.turn, goal.turn, s.turn_acceleration * step, s.turn_deceleration * step);
    // Without a goal the motors are off, whatever the encoders say: a controller whose encoder counts backwards would lead
    // its wheel away from 0.
    const bool rests = is_zero(goal) && is_zero(twist_);
    for (uint8_t i = 0; i < wheels(); i++) {
      const int32_t ticks = io_.ticks(i);
      const int32_t moved = (int32_t)((uint32_t)ticks - (uint32_t)ticks_[i]);
      ticks_[i] = ticks;
      speeds_[i] = moved / s.ticks_per_metre / step;
      const float wanted = wheel_speed(s.kind, s.track, twist_, i);
      float duty = wheels_[i].control(wanted, speeds_[i], s.full, s.proportional, s.integral, s.correction, step);
      stalled_ = stalled_ || wheels_[i].is_stalled();
      if (rests) {
        wheels_[i].reset();
        duty = 0;
      }
      if (stalled_) {
        wheels_[i].reset();
        twist_ = {0, 0, 0};
        duty = 0;
      }
      io_.drive(i, duty);
    }
  }

  // What it is. Returns whether the line is on its way.
  bool hello(uint16_t number) {
    const Settings &s = settings_;
    LineWriter line;
    line.word("hello 1");
    line.count("for", number);
    line.word(s.kind == kDifferential ? " kind=differential" : " kind=omnidirectional");
    line.word(" firmware=jde-base/1 serial=");
    line.word(s.serial);
    line.count("watchdog", kWatchdog);
    line.count("period", kPeriod);
    line.field("speed", thousandths(s.speed));
    line.field("side", thousandths(s.side));
    line.field("turn", thousandths(s.turn));
    line.field("up", thousandths(s.acceleration));
    line.field("down", thousandths(s.deceleration));
    line.field("turn_up", thousandths(s.turn_acceleration));
    line.field("turn_down", thousandths(s.turn_deceleration));
    line.field("lag", thousandths(s.lag));
    if (s.kind == kDifferential) {
      line.field("track", (int32_t)lroundf(s.track * 1e6f));
      line.field("ticks", thousandths(s.ticks_per_metre));
      line.field("bits", 32);
    }
    if (s.charged > 0) {
      line.field("empty", thousandths(s.empty));
      line.field("full", thousandths(s.charged));
    }
    return send(line);
  }

  // What it senses now. A line that has no room is lost, as its number tells.
  void state(uint32_t now, float step) {
    LineWriter line;
    line.word("s ");
    line.number(sent_++);
    line.count("t", now);
    if (has_command_) line.count("ack", acknowledged_);
    line.count("bad", bad_);
    if (settings_.kind == kDifferential) {
      line.field("left", ticks_[0]);
      line.field("right", ticks_[1]);
    } else {
      // What is lost by rounding is added to the next line, so that no way is lost.
      const Twist twist = base_speed(settings_.kind, settings_.track, speeds_);
      const float exact[3] = {twist.ahead, twist.left, twist.turn};
      static const char *const kKeys[3] = {"vx", "vy", "wz"};
      for (uint8_t i = 0; i < 3; i++) {
        const float way = exact[i] * step + rest_[i];
        const int32_t rounded = thousandths(way / step);
        rest_[i] = way - rounded / 1000.0f * step;
        line.field(kKeys[i], rounded);
      }
    }
    Senses senses;
    io_.sense(senses);
    if (stalled_) line.word(" stalled=1");
    if (senses.front) {
      line.key("front");
      line.word(senses.front);
    }
    if (senses.rear) {
      line.key("rear");
      line.word(senses.rear);
    }
    if (senses.battery >= 0) line.field("battery", thousandths(senses.battery));
    if (senses.imu) {
      vector(line, "gyro", senses.gyro, 1e6f);
      vector(line, "acc", senses.acc, 1e3f);
    }
    send(line);
  }

  static void vector(LineWriter &line, const char *key, const float *values, float units) {
    line.key(key);
    for (uint8_t i = 0; i < 3; i++) {
      if (i) line.put(',');
      line.number((int32_t)lroundf(values[i] * units));
    }
  }

  static int32_t thousandths(float value) { return (int32_t)lroundf(value * 1000); }

  bool send(LineWriter &line) {
    const size_t size = line.end();
    return io_.send(line.text(), size);
  }

  const Settings settings_;
  Io &io_;
  LineReader reader_;
  Wheel wheels_[4];
  int32_t ticks_[4] = {};
  float speeds_[4] = {};
  float rest_[3] = {};
  Twist goal_ = {0, 0, 0};   // what is commanded
  Twist twist_ = {0, 0, 0};  // what the accelerations permit of it
  uint32_t commanded_ = 0, due_ = 0, last_ = 0, bad_ = 0;
  uint16_t acknowledged_ = 0, sent_ = 0, greeting_ = 0;
  bool has_greeting_ = false;
  bool has_command_ = false;
  bool stalled_ = false;
};

}  // namespace jde
