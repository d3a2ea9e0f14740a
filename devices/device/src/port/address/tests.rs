//! Valid and invalid addresses.

use proptest::prelude::*;

use super::*;

#[track_caller]
fn check_round_trip(text: &str, formatted: &str) {
    let address = Address::parse(text).expect("an address");
    assert_eq!(address.to_string(), formatted);
    assert_eq!(Address::parse(formatted).as_ref(), Ok(&address));
}

#[track_caller]
fn check_refused(text: &str, expected: &str) {
    let message = Address::parse(text).expect_err("no address").to_string();
    assert!(message.contains(expected), "`{expected}` is not in `{message}`");
}

#[test]
fn addresses_are_parsed_and_formatted() {
    check_round_trip("tcp:192.168.0.10:10940", "tcp:192.168.0.10:10940");
    check_round_trip(" tcp:scanner.local:80 ", "tcp:scanner.local:80");
    check_round_trip("tcp:[::1]:8101", "tcp:[::1]:8101");
    check_round_trip("serial:/dev/ttyUSB0@9600", "serial:/dev/ttyUSB0@9600");
    check_round_trip("serial:/dev/ttyS0@500000,8N1", "serial:/dev/ttyS0@500000");
    check_round_trip("serial:/dev/ttyS0@9600,7e2", "serial:/dev/ttyS0@9600,7E2");
    check_round_trip("serial:/dev/by@id@115200,8O1", "serial:/dev/by@id@115200,8O1");
}

#[test]
fn an_invalid_address_is_refused_with_the_expected_form() {
    check_refused("", "write tcp:HOST:PORT");
    check_refused("/dev/ttyUSB0", "serial:PATH@BAUD");
    check_refused("udp:host:1", "write tcp:HOST:PORT");
    check_refused("tcp:host", "a number from 1 to 65535");
    check_refused("tcp:host:0", "a number from 1 to 65535");
    check_refused("tcp:host:+80", "a number from 1 to 65535");
    check_refused("tcp:host:65536", "a number from 1 to 65535");
    check_refused("tcp::80", "names no host");
    check_refused("tcp:::1:80", "tcp:[::1]:10940");
    check_refused("tcp:[host]:80", "names no host");
    check_refused("tcp:a b:80", "names no host");
    check_refused("serial:", "names no device file");
    check_refused("serial:@9600", "names no device file");
    check_refused("serial:/dev/ttyUSB0", "bits per second follow");
    check_refused("serial:/dev/ttyUSB0@", "bits per second follow");
    check_refused("serial:/dev/ttyUSB0@fast", "bits per second follow");
    check_refused("serial:/dev/ttyUSB0@0", "bits per second follow");
    check_refused("serial:/dev/ttyUSB0@9600,9N1", "7 or 8 data bits");
    check_refused("serial:/dev/ttyUSB0@9600,8X1", "N, E or O");
    check_refused("serial:/dev/ttyUSB0@9600,8N1 ?", "like 8N1");
}

proptest! {
    #[test]
    fn parsing_never_panics_and_every_address_survives_a_round_trip(text in "(tcp:|serial:)?[ -~]{0,30}") {
        if let Ok(address) = Address::parse(&text) {
            prop_assert_eq!(Address::parse(&address.to_string()), Ok(address));
        }
    }
}
