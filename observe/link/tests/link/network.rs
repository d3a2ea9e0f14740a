//! Applications on the network: which clients they admit, and what those may do.

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use std::time::Duration;

use jde_link::message::{Action, Network, Request};
use jde_link::{Access, Client, Error, Events, Link, Login, Rate, Reach, Settings, Tls};
use jde_panel::{Gesture, Touch};
use zenoh::Wait;

use crate::common::{TIMEOUT, TestRuntime, TestSubject, number, raw_session, watch, write};

/// A local address with a free port.
pub(crate) fn free_address() -> String {
    let port = TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap()
        .port();
    format!("127.0.0.1:{port}")
}

/// A networked application on a free port.
pub(crate) fn open(
    runtime: &TestRuntime,
    protocol: &str,
    configure: impl Fn(&mut Settings),
) -> (Link, std::sync::Arc<TestSubject>, String) {
    let subject = TestSubject::new();
    loop {
        let endpoint = format!("{protocol}/{}", free_address());
        let mut settings = runtime.settings("robot");
        settings.listen = vec![endpoint.clone()];
        settings.insecure = protocol == "tcp";
        configure(&mut settings);
        match Link::open(&settings, subject.clone(), &Events::of_records()) {
            Ok(link) => return (link, subject, endpoint),
            // Another test has taken the port.
            Err(Error::Listen { .. }) => {}
            Err(error) => panic!("{error}"),
        }
    }
}

pub(crate) fn reach(endpoint: &str, login: Option<Login>, tls: Option<Tls>) -> Reach {
    Reach::Network {
        endpoints: vec![endpoint.to_owned()],
        login,
        tls,
    }
}

pub(crate) fn play() -> Request {
    Request {
        by: "ana".to_owned(),
        action: Action::Play {
            schema: "goon".to_owned(),
        },
        lease_ms: None,
    }
}

pub(crate) fn login(user: &str, password: &str) -> Login {
    Login {
        user: user.to_owned(),
        password: password.to_owned(),
    }
}

#[test]
fn clients_from_the_network_read_and_operate_only_with_permission() {
    for access in [Access::Read, Access::Operate] {
        let runtime = TestRuntime::new();
        let (link, subject, endpoint) = open(&runtime, "tcp", |settings| settings.access = access);
        let client = Client::connect(&reach(&endpoint, None, None)).unwrap();
        assert_eq!(client.applications().unwrap(), [link.about().clone()]);
        let remote = client.application(Some("robot")).unwrap();
        let mut writer = subject.writer("pioneer.bearing");
        write(&mut writer, 1.5, 1);
        assert_eq!(number(&remote.get("pioneer.bearing").unwrap()), Some(1.5));
        let (_subscription, received) = watch(&remote, "pioneer.bearing", Rate::Full);
        assert_eq!(number(&received.recv_timeout(TIMEOUT).unwrap()), Some(1.5));
        match access {
            Access::Read => {
                assert_eq!(link.about().network, Network::Read);
                let error = remote.operate(&play()).err().unwrap().to_string();
                assert!(error.contains("may only read"), "{error}");
                let gesture = Gesture {
                    widget: "field".to_owned(),
                    touch: Touch::Pressed,
                };
                let touched = remote.touch("ana", "goon", gesture);
                assert!(touched.err().unwrap().to_string().contains("may only read"));
                assert_eq!(subject.actions(), []);
                // The same user on the same machine may operate.
                runtime.remote().operate(&play()).unwrap();
            }
            Access::Operate => remote.operate(&play()).unwrap(),
        }
        assert_eq!(subject.actions().len(), 1);
        drop(link);
        assert!(remote.wait_gone(TIMEOUT));
    }
}

#[test]
fn a_client_without_the_password_is_refused() {
    let (runtime, files) = (TestRuntime::new(), tempfile::tempdir().unwrap());
    let trusted = authority(files.path(), "trusted");
    let (_link, _, endpoint) = open(&runtime, "tls", |settings| {
        settings.login = Some(login("lab", "right"));
        settings.tls = Some(trusted.tls(true, false));
    });
    let connect = |login| {
        let reach = reach(&endpoint, login, Some(trusted.tls(false, false)));
        Client::connect(&reach).map(|client| client.applications())
    };
    for wrong in [None, Some(login("lab", "wrong")), Some(login("bal", "right"))] {
        let error = connect(wrong.clone()).err();
        assert!(
            matches!(error, Some(Error::Connect { .. })),
            "{wrong:?}: {error:?}"
        );
    }
    let applications = connect(Some(login("lab", "right"))).unwrap().unwrap();
    assert_eq!(applications.len(), 1);
    let secret_files = std::fs::read_dir(runtime.folder.path()).unwrap().flatten();
    let secret_files: Vec<_> = secret_files
        .filter(|file| file.file_name().to_string_lossy().ends_with(".tmp"))
        .collect();
    assert!(secret_files.is_empty(), "the file with the password is removed");
}

/// A certificate authority with a certificate for this machine, as files.
pub(crate) struct Authority {
    certificate: PathBuf,
    identity: (String, String),
}

impl Authority {
    /// Settings that trust the authority; `present` presents its certificate, `clients` requires one of each
    /// client.
    pub(crate) fn tls(&self, present: bool, clients: bool) -> Tls {
        Tls {
            identity: present.then(|| self.identity.clone()),
            authority: Some(self.certificate.to_string_lossy().into_owned()),
            clients,
        }
    }
}

pub(crate) fn authority(folder: &Path, name: &str) -> Authority {
    let mut parameters = rcgen::CertificateParams::new(Vec::new()).unwrap();
    parameters.is_ca = rcgen::IsCa::Ca(rcgen::BasicConstraints::Unconstrained);
    let key = rcgen::KeyPair::generate().unwrap();
    let certificate = parameters.self_signed(&key).unwrap();
    let issuer = rcgen::Issuer::new(parameters, key);
    let own_key = rcgen::KeyPair::generate().unwrap();
    let names = vec!["localhost".to_owned(), "127.0.0.1".to_owned()];
    let own = rcgen::CertificateParams::new(names)
        .unwrap()
        .signed_by(&own_key, &issuer)
        .unwrap();
    let write = |part: &str, text: String| {
        let path = folder.join(format!("{name}-{part}.pem"));
        std::fs::write(&path, text).unwrap();
        path
    };
    let text = |path: PathBuf| path.to_string_lossy().into_owned();
    Authority {
        certificate: write("ca", certificate.pem()),
        identity: (
            text(write("certificate", own.pem())),
            text(write("key", own_key.serialize_pem())),
        ),
    }
}

#[test]
fn an_end_without_a_certificate_of_the_authority_is_refused() {
    let (runtime, files) = (TestRuntime::new(), tempfile::tempdir().unwrap());
    let (trusted, foreign) = (
        authority(files.path(), "trusted"),
        authority(files.path(), "foreign"),
    );
    let tls = |authority: &Authority, identity: Option<&Authority>| Tls {
        identity: identity.map(|identity| identity.identity.clone()),
        authority: Some(authority.certificate.to_string_lossy().into_owned()),
        clients: true,
    };
    let valid = tls(&trusted, Some(&trusted));
    let (_link, _, endpoint) = open(&runtime, "tls", |settings| settings.tls = Some(valid.clone()));
    let applications = |tls| {
        let client = Client::connect(&reach(&endpoint, None, Some(tls)))?;
        client.applications()
    };
    assert_eq!(applications(valid.clone()).unwrap().len(), 1);
    for (case, wrong) in [
        ("a server of another authority", tls(&foreign, Some(&trusted))),
        ("a client of another authority", tls(&trusted, Some(&foreign))),
        ("a client without a certificate", tls(&trusted, None)),
    ] {
        let found = applications(wrong);
        assert!(
            !matches!(&found, Ok(found) if !found.is_empty()),
            "{case} is admitted: {found:?}"
        );
    }
    let plain = endpoint.replace("tls/", "tcp/");
    assert!(
        Client::connect(&reach(&plain, None, None)).is_err(),
        "a client without TLS is refused"
    );
}

#[test]
fn a_port_in_use_and_one_without_a_listener_are_reported() {
    let runtime = TestRuntime::new();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let endpoint = format!("tcp/{}", taken.local_addr().unwrap());
    let mut settings = runtime.settings("robot");
    settings.listen = vec![endpoint.clone()];
    settings.insecure = true;
    let error = Link::open(&settings, TestSubject::new(), &Events::of_records())
        .err()
        .unwrap();
    assert!(
        matches!(&error, Error::Listen { endpoint: reported, .. } if *reported == endpoint),
        "{error}"
    );
    assert!(
        runtime.client().applications().unwrap().is_empty(),
        "the failed application is not announced"
    );
    let unused = format!("tcp/{}", free_address());
    let error = Client::connect(&reach(&unused, None, None)).err().unwrap();
    assert!(
        matches!(&error, Error::Connect { endpoint, .. } if *endpoint == unused),
        "{error}"
    );
}

#[test]
fn a_peer_of_another_version_is_named_with_both_versions() {
    let runtime = TestRuntime::new();
    let link = runtime.open("robot", &TestSubject::new());
    let mut about = link.about().clone();
    (about.name, about.id) = ("robot9".to_owned(), "0123456789abcdef".to_owned());
    (about.protocol, about.version) = (9, "9.9.9".to_owned());
    let path = runtime.folder.path().join(format!("{}.json", about.id));
    std::fs::write(&path, serde_json::to_string(&about).unwrap()).unwrap();
    let lock = std::fs::File::open(&path).unwrap();
    lock.lock().unwrap();
    let error = runtime
        .client()
        .application(Some("robot9"))
        .err()
        .unwrap()
        .to_string();
    let own_version = env!("CARGO_PKG_VERSION");
    assert_eq!(
        error,
        format!(
            "`robot9` (jde 9.9.9) speaks link protocol 9, and this is protocol 1 (jde {own_version}); use the same version of jde on both"
        )
    );
    drop(lock);
    assert_eq!(
        runtime.client().applications().unwrap().len(),
        1,
        "an announcement without a lock is removed"
    );
    assert!(!path.exists());
}

/// The keys of all replies to a query.
fn reply_keys(session: &zenoh::Session, key: &str) -> Vec<String> {
    let (sender, received) = channel();
    session
        .get(key)
        .target(zenoh::query::QueryTarget::All)
        .consolidation(zenoh::query::ConsolidationMode::None)
        .timeout(Duration::from_secs(20))
        .callback(move |reply| {
            if let Ok(sample) = reply.into_result() {
                sender.send(sample.key_expr().to_string()).unwrap();
            }
        })
        .wait()
        .unwrap();
    received.iter().collect()
}

#[test]
fn no_client_can_impersonate_an_application() {
    let runtime = TestRuntime::new();
    let (link, subject, endpoint) = open(&runtime, "tcp", |_| {});
    let client = Client::connect(&reach(&endpoint, None, None)).unwrap();
    let remote = client.application(None).unwrap();
    let mut writer = subject.writer("pioneer.bearing");
    write(&mut writer, 1.0, 1);
    let (_subscription, received) = watch(&remote, "pioneer.bearing", Rate::Full);
    assert_eq!(number(&received.recv_timeout(TIMEOUT).unwrap()), Some(1.0));

    let (impostor, publisher) = (raw_session(&endpoint), raw_session(&endpoint));
    let root = format!("jde/1/robot/{}", link.about().id);
    let _queryable = impostor
        .declare_queryable("jde/**")
        .callback(|query| {
            let _ = query.reply(query.key_expr().clone(), "forged").wait();
        })
        .wait()
        .unwrap();
    let _token = impostor
        .liveliness()
        .declare_token("jde/1/ghost/00/alive")
        .wait()
        .unwrap();
    let mut attachment = vec![0; 33];
    attachment[0] = 99;
    let forged = {
        let mut message = Vec::new();
        let number = 6.66_f64.to_ne_bytes();
        jde_ros::cdr::encode(&<f64 as jde_types::Value>::describe(), &number, &mut message);
        message
    };
    for key in [
        format!("{root}/var/pioneer/bearing/full"),
        "jde/**".to_owned(),
        format!("{root}/**"),
    ] {
        publisher
            .put(key, forged.clone())
            .attachment(attachment.clone())
            .wait()
            .unwrap();
    }
    // A reply implies that all earlier messages were processed.
    assert_eq!(
        reply_keys(&publisher, &format!("{root}/about")),
        [format!("{root}/about")]
    );
    write(&mut writer, 2.0, 2);
    assert_eq!(
        number(&received.recv_timeout(TIMEOUT).unwrap()),
        Some(2.0),
        "no forged value arrives"
    );
    assert_eq!(client.applications().unwrap(), [link.about().clone()]);
    assert_eq!(remote.schemas().unwrap().schemas.len(), 0);
}

#[test]
fn no_client_reaches_another_application_through_one() {
    let runtime = TestRuntime::new();
    let (link, _, endpoint) = open(&runtime, "tcp", |_| {});
    let _private = runtime.open("private", &TestSubject::new());
    let raw_session = raw_session(&endpoint);
    let about = format!("jde/1/robot/{}/about", link.about().id);
    assert_eq!(reply_keys(&raw_session, "jde/*/*/*/about"), [about]);
    assert_eq!(runtime.client().applications().unwrap().len(), 2);
}
