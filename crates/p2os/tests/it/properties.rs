//! Decoding after encoding returns the same, for every command and every answer, whatever its numbers.

use jde_p2os::*;
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;

/// Commands with a signed number, with an unsigned one, and with bytes.
const SIGNED: &[fn(i16) -> Command] = &[
    Command::Acceleration,
    Command::Move,
    Command::Rotate,
    Command::Velocity,
    Command::Heading,
    Command::DeltaHeading,
    Command::RotVelocity,
    Command::CompassHeading,
    Command::RotAcceleration,
    Command::LaserStart36,
    Command::LaserEnd37,
    Command::SetOriginX,
    Command::SetOriginY,
    Command::SetOriginTh,
    Command::LatVelocity,
    Command::LatAcceleration,
];
const UNSIGNED: &[fn(u16) -> Command] = &[
    Command::MaxVelocity,
    Command::MaxRotVelocity,
    Command::Encoder,
    Command::Sonar,
    Command::DigitalOut,
    Command::Gripper,
    Command::LaserOn35,
    Command::LaserIncrement38,
    Command::IoRequest,
    Command::ServoPosition,
    Command::GetAux,
    Command::BumpStall,
    Command::Compass,
    Command::JoyDrive,
    Command::HostBaud,
    Command::Gyro,
    Command::GetAux3,
    Command::BatteryInfo,
    Command::Sound,
    Command::PlayList,
    Command::SimStat,
    Command::Exit,
];
const BYTES: &[fn(Vec<u8>) -> Command] = &[
    Command::Polling,
    Command::Say,
    Command::Tty2,
    Command::Tty4,
    Command::Tty3,
    Command::Message,
];
const LASERS: &[fn(ForLaser) -> Command] = &[
    Command::LrfEnable,
    Command::LrfStart,
    Command::LrfEnd,
    Command::LrfResolution,
];
const FORMS: &[fn(Form) -> Command] = &[Command::Open, Command::Close, Command::Config];
const FLAGS: &[fn(bool) -> Command] = &[Command::Enable, Command::SoundToggle];
const BARE: &[Command] = &[
    Command::Pulse,
    Command::Stop,
    Command::EStop,
    Command::QStop,
    Command::Reset69,
    Command::SimReset,
];

fn one<T: Copy + core::fmt::Debug + 'static>(of: &'static [T]) -> impl Strategy<Value = T> {
    proptest::sample::select(of)
}

fn commands() -> impl Strategy<Value = Command> {
    prop_oneof![
        (one(SIGNED), any::<i16>()).prop_map(|(make, value)| make(value)),
        (one(UNSIGNED), any::<u16>()).prop_map(|(make, value)| make(value)),
        (one(BYTES), vec(any::<u8>(), 0..190)).prop_map(|(make, value)| make(value)),
        (one(LASERS), any::<i16>(), any::<u8>())
            .prop_map(|(make, value, laser)| make(ForLaser { value, laser })),
        (one(FORMS), any::<bool>()).prop_map(|(make, one)| make(if one { Form::One } else { Form::Bare })),
        (one(FLAGS), any::<bool>()).prop_map(|(make, value)| make(value)),
        proptest::sample::select(BARE),
        (any::<i8>(), any::<i8>()).prop_map(|(left, right)| Command::Velocities2(Wheels { left, right })),
        option::of(any::<[i16; 3]>()).prop_map(Command::SetOrigin),
        any::<[i32; 3]>().prop_map(|[x, y, th]| Command::SimSetPose(SimPose { x, y, th })),
        (any::<u16>(), vec(any::<u8>(), 0..190))
            .prop_map(|(code, data)| Command::SimCtrl(SimControl { code, data })),
    ]
}

fn sips() -> impl Strategy<Value = Sip> {
    let sonars = vec((any::<u8>(), any::<u16>()), 0..54);
    let head = (
        any::<bool>(),
        any::<[u16; 3]>(),
        any::<[i16; 4]>(),
        any::<[u8; 2]>(),
        any::<u16>(),
    );
    let tail = (
        any::<[u8; 7]>(),
        any::<[u16; 2]>(),
        any::<[i16; 2]>(),
        any::<i8>(),
        0_usize..13,
    );
    (head, sonars, tail).prop_map(
        |((moving, a, b, c, flags), sonars, (d, e, f, temperature, known))| {
            // The firmware knows only this many fields of the tail.
            let mut place = 0;
            let mut knows = || {
                place += 1;
                place <= known
            };
            Sip {
                moving,
                x: a[0],
                y: a[1],
                th: b[0],
                left_velocity: b[1],
                right_velocity: b[2],
                battery: c[0],
                stall_bumpers: a[2],
                control: b[3],
                flags,
                compass: c[1],
                sonars: sonars
                    .into_iter()
                    .map(|(index, range)| SonarReading { index, range })
                    .collect(),
                gripper: knows().then_some(d[0]),
                analog_port: knows().then_some(d[1]),
                analog: knows().then_some(d[2]),
                digital_in: knows().then_some(d[3]),
                digital_out: knows().then_some(d[4]),
                battery_tenths: knows().then_some(e[0]),
                charge: knows().then_some(d[5]),
                rotation: knows().then_some(f[0]),
                faults: knows().then_some(e[1]),
                lateral: knows().then_some(f[1]),
                temperature: knows().then_some(temperature),
                state_of_charge: knows().then_some(d[6]),
            }
        },
    )
}

proptest! {
    #[test]
    fn every_command_is_read_as_it_was_written(command in commands()) {
        let packet = command.to_packet().unwrap();
        // Without an argument, OPEN and similar commands are synchronisations too.
        prop_assert_eq!(Command::from_packet(&packet), command);
    }

    #[test]
    fn every_sip_is_read_as_it_was_written(sip in sips()) {
        prop_assert_eq!(Sip::from_packet(&sip.to_packet().unwrap()).unwrap(), sip);
    }

    #[test]
    fn every_configuration_is_read_as_it_was_written(
        names in any::<[u8; 4]>(), watchdog in any::<u16>(), drift_factor in any::<i16>(), charge_threshold in any::<u16>(),
    ) {
        let name = |number: u8| format!("robot {number}");
        let config = Config {
            class: name(names[0]),
            subclass: name(names[1]),
            serial: name(names[2]),
            name: name(names[3]),
            watchdog,
            drift_factor,
            charge_threshold,
            ..Config::default()
        };
        prop_assert_eq!(Config::from_packet(&config.to_packet().unwrap()).unwrap(), config);
    }

    #[test]
    fn every_simulators_state_is_read_as_it_was_written(flags in any::<u32>(), numbers in any::<[i32; 4]>()) {
        let [x, y, th, error_th] = numbers;
        let state = SimState { flags, x, y, th, error_th, ..SimState::default() };
        prop_assert_eq!(SimState::from_packet(&state.to_packet().unwrap()).unwrap(), state);
    }

    #[test]
    fn every_sweep_comes_out_as_it_went_in(
        readings in vec((any::<u16>(), any::<u8>()), 1..1000), device in any::<u8>(), flags in any::<u8>(),
    ) {
        let reading = |(range, reflectance)| Reading { range, reflectance };
        let sweep: Vec<Reading> = readings.into_iter().map(reading).collect();
        let mut assembler = Assembler::default();
        let mut out = Vec::new();
        for part in LaserPacket::sweep(LaserForm::Extended { device, flags }, &sweep) {
            let read = LaserPacket::from_packet(&part.to_packet().unwrap()).unwrap();
            prop_assert_eq!(&read, &part);
            out.extend(assembler.add(&read));
        }
        prop_assert_eq!(out, [sweep]);
    }

    #[test]
    fn every_word_to_and_from_the_camera_is_read_as_it_was_written(
        pan in -875_i16..=875, tilt in -267_i16..=790, speed in 0_u16..0x1000, zoom in any::<u16>(),
    ) {
        let commands = [
            HeadCommand::PanTilt { pan, tilt },
            HeadCommand::PanSpeed(speed),
            HeadCommand::TiltSpeed(speed),
            HeadCommand::Zoom(zoom),
        ];
        for command in commands {
            prop_assert_eq!(HeadFrame::from_bytes(&command.to_bytes()).unwrap(), HeadFrame::Command(command));
        }
        let answer = HeadReply::position(pan, tilt);
        prop_assert_eq!(answer.pan_tilt(), Some((pan, tilt)));
        prop_assert_eq!(HeadFrame::from_bytes(&answer.to_bytes()).unwrap(), HeadFrame::Reply(answer));
    }
}
