//! What opens the network, and what hostile requests meet.

use proptest::prelude::*;

use super::worker::read_request;
use super::*;

fn checked(change: impl FnOnce(&mut Settings)) -> Result<(), String> {
    let mut settings = Settings::local("robot");
    change(&mut settings);
    check(&settings).map_err(|error| error.to_string())
}

#[test]
fn the_network_is_not_opened_by_accident() {
    let open = |endpoint: &str| {
        let listen = vec![endpoint.to_owned()];
        checked(|settings| settings.listen = listen)
    };
    assert!(open("tcp/0.0.0.0:7447").is_err());
    assert!(open("tcp/[::]:7447").is_err());
    assert!(open("tls/robot.local:7447").is_err(), "TLS alone lets anybody in");
    assert!(open("tcp/localhost.evil.example:7447").is_err());
    assert!(open("tcp/127.0.0.1:7447").is_ok());
    assert!(open("tcp/127.9.9.9:7447").is_ok());
    assert!(open("tcp/[::1]:7447#iface=lo").is_ok());
    assert!(open("tcp/localhost:7447").is_ok());
    assert!(open("unixsock-stream//run/x.sock").is_ok());
}

#[test]
fn the_network_is_opened_to_those_who_are_known_or_on_demand() {
    let listen = || vec!["tcp/0.0.0.0:7447".to_owned()];
    let login = |user: &str, password: &str| {
        Some(Login {
            user: user.to_owned(),
            password: password.to_owned(),
        })
    };
    assert!(checked(|settings| (settings.listen, settings.insecure) = (listen(), true)).is_ok());
    assert!(checked(|settings| (settings.listen, settings.login) = (listen(), login("lab", "x"))).is_ok());
    assert!(checked(|settings| (settings.listen, settings.login) = (listen(), login("lab", ""))).is_err());
    assert!(checked(|settings| (settings.listen, settings.login) = (listen(), login("a:b", "x"))).is_err());
    let tls = |clients| {
        Some(Tls {
            clients,
            ..Tls::default()
        })
    };
    assert!(checked(|settings| (settings.listen, settings.tls) = (listen(), tls(true))).is_ok());
    assert!(checked(|settings| (settings.listen, settings.tls) = (listen(), tls(false))).is_err());
}

proptest! {
    #[test]
    fn no_bytes_upset_operate(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let _ = read_request(&bytes);
    }

    #[test]
    fn no_json_upsets_operate(action in "[a-z-]{0,9}", schema in any::<String>(), lease in any::<i64>()) {
        let json = serde_json::json!({ "by": 1, "action": action, "schema": schema, "lease_ms": lease });
        prop_assert!(read_request(json.to_string().as_bytes()).is_err(), "nobody is called 1");
    }
}

#[test]
fn a_request_reads_as_documented() {
    let json = br#"{"by":"ana@laptop","action":"modulate","schema":"goon","variable":"gain","value":0.5,"lease_ms":2000}"#;
    let request = read_request(json).unwrap();
    assert_eq!(request.by, "ana@laptop");
    assert_eq!(request.action.schema(), "goon");
    assert_eq!(request.lease_ms, Some(2000));
    assert!(read_request(&vec![b' '; 2 << 20]).is_err());
    assert!(read_request(br#"{"by":"a","action":"explode","schema":"goon"}"#).is_err());
}

#[test]
fn whoever_sits_at_an_address_may_only_look_unless_it_is_known_who_that_is() {
    let access = |change: &dyn Fn(&mut Settings)| {
        let mut settings = Settings::local("robot");
        change(&mut settings);
        settings.network_access()
    };
    let tcp = || vec!["tcp/base.local:7447".to_owned()];
    let authority = || {
        Some(Tls {
            authority: Some("ca.pem".to_owned()),
            ..Tls::default()
        })
    };
    assert_eq!(access(&|settings| settings.connect = tcp()), Access::Read);
    assert_eq!(access(&|settings| settings.discover = true), Access::Read);
    let tls = |settings: &mut Settings| {
        (settings.connect, settings.tls) = (vec!["tls/base.local:7447".to_owned()], authority());
    };
    assert_eq!(access(&tls), Access::Operate);
    assert_eq!(
        access(&|settings| (settings.connect, settings.insecure) = (tcp(), true)),
        Access::Operate
    );
    let here = |settings: &mut Settings| settings.connect = vec!["tcp/127.0.0.1:7447".to_owned()];
    assert_eq!(access(&here), Access::Operate);
}
