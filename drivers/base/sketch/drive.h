// From the speeds of a base to those of its wheels and back, within accelerations, and the speed control of one wheel. It
// knows no Arduino.
#pragma once

#include <math.h>
#include <stdint.h>

namespace jde {

enum Kind : uint8_t {
  kDifferential,  // wheels: left, right
  kMecanum,       // wheels: front left, front right, rear left, rear right; rollers as an X seen from above
};

// The speeds of a base: m/s ahead and to the left, rad/s counter-clockwise.
struct Twist {
  float ahead, left, turn;
};

inline uint8_t wheels_of(Kind kind) { return kind == kDifferential ? 2 : 4; }

// The speed of a wheel on the floor, m/s. `track` is the distance of left and right wheels; of mecanum wheels, plus that of
// front and rear ones.
inline float wheel_speed(Kind kind, float track, const Twist &twist, uint8_t wheel) {
  const float side = wheel % 2 ? 1.0f : -1.0f;
  const float slide = kind == kDifferential ? 0.0f : (wheel == 0 || wheel == 3 ? -1.0f : 1.0f);
  return twist.ahead + slide * twist.left + side * twist.turn * track / 2;
}

// The speeds of a base whose wheels have these.
inline Twist base_speed(Kind kind, float track, const float *wheels) {
  if (kind == kDifferential) return {(wheels[0] + wheels[1]) / 2, 0, (wheels[1] - wheels[0]) / track};
  return {(wheels[0] + wheels[1] + wheels[2] + wheels[3]) / 4, (-wheels[0] + wheels[1] + wheels[2] - wheels[3]) / 4,
          (-wheels[0] + wheels[1] - wheels[2] + wheels[3]) / (2 * track)};
}

// Leads a speed to its goal: at most `up` away from 0, or `down` towards it. A reversal passes 0 first.
inline float approach(float value, float goal, float up, float down) {
  if (value * goal < 0) goal = 0;
  const float step = fabsf(goal) < fabsf(value) ? down : up;
  const float change = goal - value;
  if (fabsf(change) <= step) return goal;
  return value + (change < 0 ? -step : step);
}

// Lessens all parts by the same ratio to what is within the limits: an arc stays its arc.
inline Twist within(const Twist &twist, float ahead, float left, float turn) {
  const float parts[3] = {fabsf(twist.ahead), fabsf(twist.left), fabsf(twist.turn)}, limits[3] = {ahead, left, turn};
  float ratio = 1;
  for (uint8_t i = 0; i < 3; i++) {
    if (parts[i] * ratio > limits[i]) ratio = limits[i] / parts[i];
  }
  return {twist.ahead * ratio, twist.left * ratio, twist.turn * ratio};
}

inline bool is_zero(const Twist &twist) { return twist.ahead == 0 && twist.left == 0 && twist.turn == 0; }

inline float clamp(float value, float limit) { return value > limit ? limit : (value < -limit ? -limit : value); }

// The speed control of a wheel: a share of its voltage for the speed it should have, and a PI controller for the rest.
class Wheel {
 public:
  // Time for which the controller may add all that it can while the wheel does not turn as it should, s: a motor that is
  // blocked gets hot, and one whose encoder says nothing or counts backwards is not controlled.
  static constexpr float kPatience = 0.6f;

  // Returns the duty from -1 to 1. `full` is the speed at the full duty, m/s; `proportional` is 1/(m/s), `integral` 1/m;
  // `correction` is the greatest duty that they add to the one for the goal, or take from it.
  float control(float goal, float speed, float full, float proportional, float integral, float correction, float step) {
    if (goal == 0 && is_still(speed, full)) {
      reset();
      return 0;
    }
    const float error = goal - speed;
    const float wanted = proportional * error + sum_;
    const float added = clamp(wanted, correction);
    const float duty = clamp(goal / full + added, 1);
    const bool has_room = wanted == added && duty == goal / full + added;
    // The sum does not grow while it has no room.
    if (has_room || wanted * error < 0) sum_ = clamp(sum_ + integral * error * step, correction);
    const bool turns = goal == 0 ? speed * duty > 0 : speed * goal >= 0.1f * goal * goal;
    failing_ = has_room || turns ? 0 : failing_ + step;
    return duty;
  }

  // Whether a measured speed is that of a wheel that stands.
  static bool is_still(float speed, float full) { return fabsf(speed) < 0.02f * full; }

  bool is_stalled() const { return failing_ > kPatience; }

  void reset() { sum_ = failing_ = 0; }

 private:
  float sum_ = 0;
  float failing_ = 0;
};

}  // namespace jde
