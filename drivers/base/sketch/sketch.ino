// A base for jde: two motors with encoders, at an Arduino (AVR) or an ESP32. The protocol, and what each number does:
// docs/drivers/base.md of jde. Measure your robot, fill in what is marked FILL IN, and load this folder as it is.
//
// Lift the robot before its first command: a wheel whose encoder counts backwards is stopped only after half a second.

#include "board.h"

// FILL IN the pins. DIRECTION and SPEED go to a motor driver with one of each for a motor, such as L298N, TB6612 or Cytron;
// encoders need pins with interrupts: on an Uno 2 and 3 are the only ones.
struct Pins {
  uint8_t encoder_a, encoder_b, direction, speed;
};
const Pins kPins[2] = {
    {2, 4, 7, 5},   // left
    {3, 8, 12, 6},  // right
};
// FILL IN whether a motor or an encoder is mounted so that it runs the other way.
const bool kMotorReversed[2] = {false, true};
const bool kEncoderReversed[2] = {false, true};

// FILL IN the bumpers, which connect their pins to ground when pressed: from left to right; -1 for none.
const int kFrontBumpers[2] = {-1, -1};
// FILL IN the pin of the battery's voltage divider, -1 for none, and the volts for the greatest reading of the pin.
const int kBatteryPin = -1;
const float kBatteryVolts = 15.0f;

jde::Settings settings() {
  jde::Settings s = {};
  s.kind = jde::kDifferential;
  s.serial = "my-robot";      // FILL IN: its name, without spaces; `serial_number` of the driver may ask for it
  s.track = 0.23f;            // FILL IN, m: turn it ten times on the spot, and correct until the odometry says ten, too
  s.ticks_per_metre = 5200;   // FILL IN: push it 2 m straight ahead, and halve what `left` and `right` count
  s.full = 0.8f;              // FILL IN, m/s: the speed of a wheel at the full voltage
  s.speed = 0.4f;             // FILL IN, m/s: the greatest speed; speed + turn x track / 2 must be less than `full`
  s.turn = 2.0f;              // FILL IN, rad/s
  s.acceleration = 0.6f;      // FILL IN, m/s2: with what the wheels do not slip and nothing tips over
  s.deceleration = 0.9f;
  s.turn_acceleration = 4.0f;   // rad/s2
  s.turn_deceleration = 6.0f;
  s.lag = 0.1f;               // FILL IN, s: after this time its speed has 63 % of a step
  s.proportional = 1.0f;      // 1/(m/s): less if a wheel trembles
  s.integral = 6.0f;          // 1/m: less if its speed swings
  s.empty = 9.9f;             // V: of three lithium cells
  s.charged = 12.6f;
  return s;
}

volatile int32_t counts[2] = {0, 0};

#ifndef IRAM_ATTR
#define IRAM_ATTR  // an ESP32 keeps interrupts' code in its memory
#endif

void IRAM_ATTR count(uint8_t wheel) {
  const Pins &pins = kPins[wheel];
  const bool forward = (digitalRead(pins.encoder_a) == digitalRead(pins.encoder_b)) != kEncoderReversed[wheel];
  counts[wheel] = counts[wheel] + (forward ? 1 : -1);
}

void IRAM_ATTR count_left() { count(0); }
void IRAM_ATTR count_right() { count(1); }

class Hardware : public jde::Io {
 public:
  void begin() {
    for (uint8_t i = 0; i < 2; i++) {
      pinMode(kPins[i].encoder_a, INPUT_PULLUP);
      pinMode(kPins[i].encoder_b, INPUT_PULLUP);
      pinMode(kPins[i].direction, OUTPUT);
      pinMode(kPins[i].speed, OUTPUT);
      if (kFrontBumpers[i] >= 0) pinMode(kFrontBumpers[i], INPUT_PULLUP);
      drive(i, 0);
    }
    attachInterrupt(digitalPinToInterrupt(kPins[0].encoder_a), count_left, CHANGE);
    attachInterrupt(digitalPinToInterrupt(kPins[1].encoder_a), count_right, CHANGE);
  }

  int32_t ticks(uint8_t wheel) override {
    noInterrupts();
    const int32_t value = counts[wheel];
    interrupts();
    return value;
  }

  void drive(uint8_t wheel, float duty) override {
    const bool forward = (duty >= 0) != kMotorReversed[wheel];
    digitalWrite(kPins[wheel].direction, forward ? HIGH : LOW);
    analogWrite(kPins[wheel].speed, (int)(fabsf(duty) * 255));
  }

  void sense(jde::Senses &senses) override {
    uint8_t size = 0;
    for (uint8_t i = 0; i < 2; i++) {
      if (kFrontBumpers[i] >= 0) front_[size++] = digitalRead(kFrontBumpers[i]) == LOW ? '1' : '0';
    }
    front_[size] = 0;
    if (size) senses.front = front_;
#ifdef ESP32
    const float greatest = 4095;
#else
    const float greatest = 1023;
#endif
    if (kBatteryPin >= 0) senses.battery = analogRead(kBatteryPin) * kBatteryVolts / greatest;
  }

  void send(const char *line, size_t size) override { Serial.write((const uint8_t *)line, size); }

 private:
  char front_[3] = "";
};

Hardware hardware;
jde::Board board(settings(), hardware);

void setup() {
  Serial.begin(115200);
  hardware.begin();
  board.begin(millis());
}

void loop() {
  while (Serial.available() > 0) board.receive((char)Serial.read(), millis());
  board.poll(millis());
}
