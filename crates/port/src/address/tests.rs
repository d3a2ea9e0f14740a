//! Valid and invalid addresses.

use proptest::prelude::*;

use super::*;

#[track_caller]
fn same(text: &str, written: &str) {
    let address = Address::parse(text).expect("an address");
    assert_eq!(address.to_string(), written);
    assert_eq!(Address::parse(written).as_ref(), Ok(&address));
}

#[track_caller]
fn refused(text: &str, expected: &str) {
    let words = Address::parse(text).expect_err("no address").to_string();
    assert!(words.contains(expected), "`{expected}` is not in `{words}`");
}

#[test]
fn what_is_read_is_written_back() {
    same("tcp:192.168.0.10:10940", "tcp:192.168.0.10:10940");
    same(" tcp:scanner.local:80 ", "tcp:scanner.local:80");
    same("tcp:[::1]:8101", "tcp:[::1]:8101");
    same("serial:/dev/ttyUSB0@9600", "serial:/dev/ttyUSB0@9600");
    same("serial:/dev/ttyS0@500000,8N1", "serial:/dev/ttyS0@500000");
    same("serial:/dev/ttyS0@9600,7e2", "serial:/dev/ttyS0@9600,7E2");
    same("serial:/dev/by@id@115200,8O1", "serial:/dev/by@id@115200,8O1");
}

#[test]
fn a_text_that_is_no_address_is_refused_with_what_was_expected() {
    refused("", "write tcp:HOST:PORT");
    refused("/dev/ttyUSB0", "serial:PATH@BAUD");
    refused("udp:host:1", "write tcp:HOST:PORT");
    refused("tcp:host", "a number from 1 to 65535");
    refused("tcp:host:0", "a number from 1 to 65535");
    refused("tcp:host:+80", "a number from 1 to 65535");
    refused("tcp:host:65536", "a number from 1 to 65535");
    refused("tcp::80", "names no host");
    refused("tcp:::1:80", "tcp:[::1]:10940");
    refused("tcp:[host]:80", "names no host");
    refused("tcp:a b:80", "names no host");
    refused("serial:", "names no device file");
    refused("serial:@9600", "names no device file");
    refused("serial:/dev/ttyUSB0", "bits per second follow");
    refused("serial:/dev/ttyUSB0@", "bits per second follow");
    refused("serial:/dev/ttyUSB0@fast", "bits per second follow");
    refused("serial:/dev/ttyUSB0@0", "bits per second follow");
    refused("serial:/dev/ttyUSB0@9600,9N1", "7 or 8 data bits");
    refused("serial:/dev/ttyUSB0@9600,8X1", "N, E or O");
    refused("serial:/dev/ttyUSB0@9600,8N1 ?", "like 8N1");
}

proptest! {
    #[test]
    fn no_text_panics_and_every_address_survives_a_round_trip(text in "(tcp:|serial:)?[ -~]{0,30}") {
        if let Ok(address) = Address::parse(&text) {
            prop_assert_eq!(Address::parse(&address.to_string()), Ok(address));
        }
    }
}
