// A base for jde: two motors with encoders, at an Arduino (AVR) or an ESP32. The protocol, and what each number does:
// docs/drivers/base.md of jde. Measure your robot, fill in what is marked FILL IN, and load this folder as it is.
//
// Lift the robot before its first command: a wheel whose encoder counts backwards is stopped only after half a second.

#include "board.h"

#if defined(__AVR__)
#include <avr/wdt.h>
#elif defined(ESP32)
#include <esp_task_wdt.h>
#endif

// FILL IN the pins. SPEED goes to the input for the PWM of a motor, with a pull-down of 10 kOhm: the motor must be off while
// the board starts. A driver with one input for the direction (Cytron MD10C) has it at DIRECTION, and OPPOSITE is -1. One
// with two (IN1 and IN2 of L298N and TB6612, whose PWM is ENA or PWMA) has them at DIRECTION and OPPOSITE. Others, with two
// PWM inputs (DRV8833), are not for this sketch. Encoders need pins with interrupts: on an Uno 2 and 3 are the only ones.
struct Pins {
  uint8_t encoder_a, encoder_b, direction;
  int8_t opposite;
  uint8_t speed;
};
const Pins kPins[2] = {
#if defined(__AVR__)
    {2, 4, 7, -1, 5},   // left
    {3, 8, 12, -1, 6},  // right
#elif defined(CONFIG_IDF_TARGET_ESP32)
    {32, 33, 18, -1, 19},  // left
    {25, 26, 22, -1, 23},  // right
#else
#error "FILL IN the pins of this board: not those of its flash, its USB, its serial line and its start"
#endif
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
  s.serial = "my-robot";      // FILL IN: its name, without spaces; `serial_number` of the driver asks for it
  s.track = 0.23f;            // FILL IN, m: (right - left) after ten turns to the left on the spot / ticks_per_metre / 62.8
  s.ticks_per_metre = 5200;   // FILL IN: push it 2 m straight ahead, and halve what `left` and `right` count
  s.full = 0.8f;              // FILL IN, m/s: the speed of a wheel at the full voltage: turns per second x its circumference
  s.speed = 0.4f;             // FILL IN, m/s: the greatest speed; speed + turn x track / 2 must be less than `full`
  s.turn = 2.0f;              // FILL IN, rad/s
  s.acceleration = 0.6f;      // FILL IN, m/s2: with what the wheels do not slip and nothing tips over
  s.deceleration = 0.9f;
  s.turn_acceleration = 4.0f;   // rad/s2
  s.turn_deceleration = 6.0f;
  s.lag = 0.1f;               // FILL IN, s: after this time its speed has 63 % of a step
  s.proportional = 1.0f;      // 1/(m/s): less if a wheel trembles
  s.integral = 6.0f;          // 1/m: less if its speed swings
  s.correction = 0.3f;        // more if the motors do not start with it; less is safer if an encoder fails
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
      pinMode(kPins[i].speed, OUTPUT);
      pinMode(kPins[i].direction, OUTPUT);
      if (kPins[i].opposite >= 0) pinMode(kPins[i].opposite, OUTPUT);
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
    if (kPins[wheel].opposite >= 0) digitalWrite(kPins[wheel].opposite, forward ? LOW : HIGH);
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

  // Serial.write waits for room, and at a board's own USB for a computer that reads: so each line goes out in pieces.
  bool send(const char *line, size_t size) override {
    if (written_ < size_) return false;
    memcpy(line_, line, size);
    size_ = size;
    written_ = 0;
    write();
    return true;
  }

  void write() {
    const int room = Serial.availableForWrite();
    size_t size = size_ - written_;
    if (room <= 0 || size == 0) return;
    if (size > (size_t)room) size = (size_t)room;
    written_ += Serial.write((const uint8_t *)line_ + written_, size);
  }

 private:
  char front_[3] = "";
  char line_[jde::LineWriter::kSize];
  size_t size_ = 0, written_ = 0;
};

Hardware hardware;
jde::Board board(settings(), hardware);

// The chip starts anew if `loop` hangs for half a second, and the motors are off then. The boot loader of an old Nano or Mega
// hangs after that, with the motors off: load the present one.
void start_watchdog() {
#if defined(__AVR__)
  wdt_enable(WDTO_500MS);
#elif defined(ESP32)
#if ESP_ARDUINO_VERSION_MAJOR >= 3
  const esp_task_wdt_config_t half_a_second = {500, 0, true};
  esp_task_wdt_reconfigure(&half_a_second);
#else
  esp_task_wdt_init(1, true);
#endif
  enableLoopWDT();  // `loop` feeds it whenever it ends
#endif
}

void setup() {
  Serial.begin(115200);
  hardware.begin();
  board.begin(millis());
  start_watchdog();
}

void loop() {
#if defined(__AVR__)
  wdt_reset();
#endif
  // Not until there are none: a line that never rests would keep the wheels uncontrolled.
  for (uint8_t bytes = 0; bytes < 64 && Serial.available() > 0; bytes++) board.receive((char)Serial.read(), millis());
  board.poll(millis());
  hardware.write();
}
