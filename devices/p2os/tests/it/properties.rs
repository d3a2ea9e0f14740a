//! Decoding after encoding returns the same value, for every command and every reply.

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

fn any_of<T: Copy + core::fmt::Debug + 'static>(items: &'static [T]) -> impl Strategy<Value = T> {
    proptest::sample::select(items)
}

fn commands() -> impl Strategy<Value = Command> {
    prop_oneof![
        (any_of(SIGNED), any::<i16>()).prop_map(|(make, value)| make(value)),
        (any_of(UNSIGNED), any::<u16>()).prop_map(|(make, value)| make(value)),
        (any_of(BYTES), vec(any::<u8>(), 0..190)).prop_map(|(make, value)| make(value)),
        (any_of(LASERS), any::<i16>(), any::<u8>())
            .prop_map(|(make, value, laser)| make(ForLaser { value, laser })),
        (any_of(FORMS), any::<bool>()).prop_map(|(make, one)| make(if one { Form::One } else { Form::Bare })),
        (any_of(FLAGS), any::<bool>()).prop_map(|(make, value)| make(value)),
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
        |((moving, a, b, c, flags), sonars, (d, e, f, temperature, field_count))| {
            // The firmware sends only this many fields of the tail.
            let mut field = 0;
            let mut is_sent = || {
                field += 1;
                field <= field_count
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
                gripper: is_sent().then_some(d[0]),
                analog_port: is_sent().then_some(d[1]),
                analog: is_sent().then_some(d[2]),
                digital_in: is_sent().then_some(d[3]),
                digital_out: is_sent().then_some(d[4]),
                battery_tenths: is_sent().then_some(e[0]),
                charge: is_sent().then_some(d[5]),
                rotation: is_sent().then_some(f[0]),
                faults: is_sent().then_some(e[1]),
                lateral: is_sent().then_some(f[1]),
                temperature: is_sent().then_some(temperature),
                state_of_charge: is_sent().then_some(d[6]),
            }
        },
    )
}

proptest! {
    #[test]
    fn every_command_survives_encoding_and_decoding(command in commands()) {
        let packet = command.to_packet().unwrap();
        // Without an argument, OPEN and similar commands are synchronisations too.
        prop_assert_eq!(Command::from_packet(&packet), command);
    }

    #[test]
    fn every_sip_survives_encoding_and_decoding(sip in sips()) {
        prop_assert_eq!(Sip::from_packet(&sip.to_packet().unwrap()).unwrap(), sip);
    }

    #[test]
    fn every_configuration_survives_encoding_and_decoding(
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
    fn every_simulator_state_survives_encoding_and_decoding(flags in any::<u32>(), numbers in any::<[i32; 4]>()) {
        let [x, y, th, error_th] = numbers;
        let state = SimState { flags, x, y, th, error_th, ..SimState::default() };
        prop_assert_eq!(SimState::from_packet(&state.to_packet().unwrap()).unwrap(), state);
    }

    #[test]
    fn every_sweep_survives_splitting_and_reassembly(
        readings in vec((any::<u16>(), any::<u8>()), 1..1000), device in any::<u8>(), flags in any::<u8>(),
    ) {
        let reading = |(range, reflectance)| Reading { range, reflectance };
        let sweep: Vec<Reading> = readings.into_iter().map(reading).collect();
        let mut assembler = Assembler::default();
        let mut sweeps = Vec::new();
        for part in LaserPacket::sweep(LaserForm::Extended { device, flags }, &sweep) {
            let read = LaserPacket::from_packet(&part.to_packet().unwrap()).unwrap();
            prop_assert_eq!(&read, &part);
            sweeps.extend(assembler.add(&read));
        }
        prop_assert_eq!(sweeps, [sweep]);
    }

    #[test]
    fn every_camera_frame_survives_encoding_and_decoding(
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
        let reply = HeadReply::position(pan, tilt);
        prop_assert_eq!(reply.pan_tilt(), Some((pan, tilt)));
        prop_assert_eq!(HeadFrame::from_bytes(&reply.to_bytes()).unwrap(), HeadFrame::Reply(reply));
    }
}
