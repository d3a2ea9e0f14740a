//! Tests of the settings that open the network, and of hostile requests.

use proptest::prelude::*;

use super::worker::read_request;
use super::*;

fn check_settings(change: impl FnOnce(&mut Settings)) -> Result<(), String> {
    let mut settings = Settings::local("robot");
    change(&mut settings);
    check(&settings).map_err(|error| error.to_string())
}

fn tls(authority: bool, clients: bool) -> Option<Tls> {
    Some(Tls {
        authority: authority.then(|| "ca.pem".to_owned()),
        clients,
        identity: None,
    })
}

fn login(user: &str, password: &str) -> Option<Login> {
    Some(Login {
        user: user.to_owned(),
        password: password.to_owned(),
    })
}

#[test]
fn listening_requires_authenticated_clients() {
    for endpoint in [
        "tcp/0.0.0.0:7447",
        "tls/robot.local:7447",
        // Other users of this machine can connect to it as well.
        "tcp/127.0.0.1:7447",
        "tcp/[::1]:7447",
        "unixsock-stream//run/x.sock",
    ] {
        let listen = || vec![endpoint.to_owned()];
        let open = check_settings(|settings| settings.listen = listen());
        assert!(open.unwrap_err().contains("would admit any client"), "{endpoint}");
        assert_eq!(
            check_settings(|settings| (settings.listen, settings.insecure) = (listen(), true)),
            Ok(())
        );
    }
    let listen = |endpoint: &str, tls: Option<Tls>, login: Option<Login>| {
        check_settings(|settings| {
            (settings.listen, settings.tls, settings.login) = (vec![endpoint.to_owned()], tls, login)
        })
    };
    let (plain, encrypted) = ("tcp/0.0.0.0:7447", "tls/0.0.0.0:7447");
    assert_eq!(listen(encrypted, tls(true, true), None), Ok(()));
    assert!(
        listen(encrypted, tls(true, false), None).is_err(),
        "clients are not authenticated"
    );
    assert!(
        listen(encrypted, tls(false, true), None).is_err(),
        "client certificates need an authority"
    );
    assert!(
        listen(plain, tls(true, true), None).is_err(),
        "an authority has no effect without TLS"
    );
    assert_eq!(listen(encrypted, tls(true, false), login("lab", "x")), Ok(()));
}

#[test]
fn a_password_requires_tls_with_an_authority() {
    let assert_refused = |change: &dyn Fn(&mut Settings)| {
        let result = check_settings(|settings| {
            settings.login = login("lab", "x");
            change(settings);
        });
        assert!(result.unwrap_err().starts_with("a password requires"));
    };
    let tcp = || vec!["tcp/base.local:7447".to_owned()];
    let encrypted = || vec!["tls/base.local:7447".to_owned()];
    assert_refused(&|settings| settings.listen = tcp());
    assert_refused(&|settings| (settings.listen, settings.insecure) = (tcp(), true));
    assert_refused(&|settings| (settings.connect, settings.insecure) = (tcp(), true));
    assert_refused(&|settings| (settings.connect, settings.tls) = (tcp(), tls(true, true)));
    assert_refused(&|settings| (settings.connect, settings.tls) = (encrypted(), tls(false, false)));
    for (user, password) in [
        ("lab", ""),
        ("", "x"),
        ("a:b", "x"),
        ("lab", " x"),
        ("lab", "x\r"),
        ("lab ", "x"),
    ] {
        let result = check_settings(|settings| {
            (settings.listen, settings.tls) = (encrypted(), tls(true, false));
            settings.login = login(user, password);
        });
        assert!(result.is_err(), "{user:?} {password:?}");
    }
}

#[test]
fn connecting_requires_an_authenticated_peer() {
    let connect = |endpoint: &str, tls: Option<Tls>, insecure| {
        check_settings(|settings| {
            (settings.connect, settings.tls, settings.insecure) = (vec![endpoint.to_owned()], tls, insecure)
        })
    };
    for (endpoint, tls) in [
        ("tcp/base.local:7447", None),
        ("tcp/127.0.0.1:7447", None),
        ("tcp/base.local:7447", tls(true, true)),
        ("tls/base.local:7447", None),
        ("tls/base.local:7447", tls(false, false)),
    ] {
        let result = connect(endpoint, tls.clone(), false);
        assert!(
            result.unwrap_err().contains("nothing authenticates"),
            "{endpoint}"
        );
        assert_eq!(connect(endpoint, tls, true), Ok(()));
    }
    assert_eq!(connect("tls/base.local:7447", tls(true, false), false), Ok(()));
    let discover = |tls| check_settings(|settings| (settings.discover, settings.tls) = (true, tls));
    assert!(
        discover(None)
            .unwrap_err()
            .contains("nothing authenticates peers found by multicast")
    );
    assert_eq!(discover(tls(true, true)), Ok(()));
}

#[test]
fn no_public_authority_is_trusted() {
    assert!(webpki_roots::TLS_SERVER_ROOTS.is_empty());
}

proptest! {
    #[test]
    fn reading_a_request_survives_any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let _ = read_request(&bytes);
    }

    #[test]
    fn reading_a_request_refuses_json_of_wrong_types(action in "[a-z-]{0,9}", schema in any::<String>(), lease in any::<i64>()) {
        let json = serde_json::json!({ "by": 1, "action": action, "schema": schema, "lease_ms": lease });
        prop_assert!(read_request(json.to_string().as_bytes()).is_err(), "the operator's name must be a text");
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
