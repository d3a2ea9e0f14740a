//! Tests of the settings that open the network, and of hostile requests.

use proptest::prelude::*;

use super::worker::read_request;
use super::*;

fn checked(change: impl FnOnce(&mut Settings)) -> Result<(), String> {
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
fn nobody_is_let_in_who_proves_nothing() {
    for endpoint in [
        "tcp/0.0.0.0:7447",
        "tls/robot.local:7447",
        // Other users of this machine can connect to it as well.
        "tcp/127.0.0.1:7447",
        "tcp/[::1]:7447",
        "unixsock-stream//run/x.sock",
    ] {
        let listen = || vec![endpoint.to_owned()];
        let open = checked(|settings| settings.listen = listen());
        assert!(
            open.unwrap_err().contains("would let in whoever gets there"),
            "{endpoint}"
        );
        assert_eq!(
            checked(|settings| (settings.listen, settings.insecure) = (listen(), true)),
            Ok(())
        );
    }
    let listen = |endpoint: &str, tls: Option<Tls>, login: Option<Login>| {
        checked(|settings| {
            (settings.listen, settings.tls, settings.login) = (vec![endpoint.to_owned()], tls, login)
        })
    };
    let (plain, guarded) = ("tcp/0.0.0.0:7447", "tls/0.0.0.0:7447");
    assert_eq!(listen(guarded, tls(true, true), None), Ok(()));
    assert!(
        listen(guarded, tls(true, false), None).is_err(),
        "nobody is asked"
    );
    assert!(
        listen(guarded, tls(false, true), None).is_err(),
        "by whom are they signed?"
    );
    assert!(
        listen(plain, tls(true, true), None).is_err(),
        "an authority guards no other way in"
    );
    assert_eq!(listen(guarded, tls(true, false), login("lab", "x")), Ok(()));
}

#[test]
fn a_password_is_given_to_nobody_who_proves_nothing() {
    let plain = |change: &dyn Fn(&mut Settings)| {
        let refused = checked(|settings| {
            settings.login = login("lab", "x");
            change(settings);
        });
        assert!(refused.unwrap_err().starts_with("a password is given to whoever"));
    };
    let tcp = || vec!["tcp/base.local:7447".to_owned()];
    let encrypted = || vec!["tls/base.local:7447".to_owned()];
    plain(&|settings| settings.listen = tcp());
    plain(&|settings| (settings.listen, settings.insecure) = (tcp(), true));
    plain(&|settings| (settings.connect, settings.insecure) = (tcp(), true));
    plain(&|settings| (settings.connect, settings.tls) = (tcp(), tls(true, true)));
    plain(&|settings| (settings.connect, settings.tls) = (encrypted(), tls(false, false)));
    for (user, password) in [
        ("lab", ""),
        ("", "x"),
        ("a:b", "x"),
        ("lab", " x"),
        ("lab", "x\r"),
        ("lab ", "x"),
    ] {
        let refused = checked(|settings| {
            (settings.listen, settings.tls) = (encrypted(), tls(true, false));
            settings.login = login(user, password);
        });
        assert!(refused.is_err(), "{user:?} {password:?}");
    }
}

#[test]
fn nobody_is_connected_to_who_proves_nothing() {
    let connect = |endpoint: &str, tls: Option<Tls>, insecure| {
        checked(|settings| {
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
        let refused = connect(endpoint, tls.clone(), false);
        assert!(
            refused.unwrap_err().contains("nothing proves who answers"),
            "{endpoint}"
        );
        assert_eq!(connect(endpoint, tls, true), Ok(()));
    }
    assert_eq!(connect("tls/base.local:7447", tls(true, false), false), Ok(()));
    let met = |tls| checked(|settings| (settings.discover, settings.tls) = (true, tls));
    assert!(
        met(None)
            .unwrap_err()
            .contains("nothing proves who answers at what multicast finds")
    );
    assert_eq!(met(tls(true, true)), Ok(()));
}

#[test]
fn no_authority_is_believed_but_the_one_that_is_named() {
    assert!(webpki_roots::TLS_SERVER_ROOTS.is_empty());
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
