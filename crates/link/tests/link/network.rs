//! Applications on the network: which clients are admitted, and what they may do.

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use std::time::Duration;

use jde_link::message::{Action, Network, Request};
use jde_link::{Access, Client, Error, Events, Link, Login, Rate, Reach, Settings, Tls};
use jde_panel::{Gesture, Touch};
use zenoh::Wait;

use crate::common::{Home, SOON, Stage, number, stranger, watch, write};

/// A free port.
pub(crate) fn free() -> String {
    let port = TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap()
        .port();
    format!("127.0.0.1:{port}")
}

/// A networked application on a free port.
pub(crate) fn open(
    home: &Home,
    protocol: &str,
    change: impl Fn(&mut Settings),
) -> (Link, std::sync::Arc<Stage>, String) {
    let stage = Stage::new();
    loop {
        let endpoint = format!("{protocol}/{}", free());
        let mut settings = home.settings("robot");
        settings.listen = vec![endpoint.clone()];
        settings.insecure = protocol == "tcp";
        change(&mut settings);
        match Link::open(&settings, stage.clone(), &Events::of_records()) {
            Ok(link) => return (link, stage, endpoint),
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
fn clients_from_the_network_look_and_operate_only_if_they_may() {
    for access in [Access::Read, Access::Operate] {
        let home = Home::new();
        let (link, stage, endpoint) = open(&home, "tcp", |settings| settings.access = access);
        let client = Client::connect(&reach(&endpoint, None, None)).unwrap();
        assert_eq!(client.applications().unwrap(), [link.about().clone()]);
        let remote = client.application(Some("robot")).unwrap();
        let mut writer = stage.writer("pioneer.bearing");
        write(&mut writer, 1.5, 1);
        assert_eq!(number(&remote.get("pioneer.bearing").unwrap()), Some(1.5));
        let (_watching, told) = watch(&remote, "pioneer.bearing", Rate::Full);
        assert_eq!(number(&told.recv_timeout(SOON).unwrap()), Some(1.5));
        match access {
            Access::Read => {
                assert_eq!(link.about().network, Network::Read);
                let error = remote.operate(&play()).err().unwrap().to_string();
                assert!(error.contains("may only look"), "{error}");
                let gesture = Gesture {
                    widget: "field".to_owned(),
                    touch: Touch::Pressed,
                };
                let touched = remote.touch("ana", "goon", gesture);
                assert!(touched.err().unwrap().to_string().contains("may only look"));
                assert_eq!(stage.acts(), []);
                // The same user on the same machine may operate.
                home.remote().operate(&play()).unwrap();
            }
            Access::Operate => remote.operate(&play()).unwrap(),
        }
        assert_eq!(stage.acts().len(), 1);
        drop(link);
        assert!(remote.wait_gone(SOON));
    }
}

#[test]
fn whoever_has_not_the_password_stays_outside() {
    let (home, files) = (Home::new(), tempfile::tempdir().unwrap());
    let ours = authority(files.path(), "ours");
    let (_link, _, endpoint) = open(&home, "tls", |settings| {
        settings.login = Some(login("lab", "right"));
        settings.tls = Some(ours.tls(true, false));
    });
    let connected = |login| {
        let reach = reach(&endpoint, login, Some(ours.tls(false, false)));
        Client::connect(&reach).map(|client| client.applications())
    };
    for wrong in [None, Some(login("lab", "wrong")), Some(login("bal", "right"))] {
        let error = connected(wrong.clone()).err();
        assert!(
            matches!(error, Some(Error::Connect { .. })),
            "{wrong:?}: {error:?}"
        );
    }
    let applications = connected(Some(login("lab", "right"))).unwrap().unwrap();
    assert_eq!(applications.len(), 1);
    let secrets = std::fs::read_dir(home.folder.path()).unwrap().flatten();
    let secrets: Vec<_> = secrets
        .filter(|file| file.file_name().to_string_lossy().ends_with(".tmp"))
        .collect();
    assert!(secrets.is_empty(), "no password stays in a file");
}

/// A certificate authority with a certificate for this machine, as files.
pub(crate) struct Authority {
    certificate: PathBuf,
    identity: (String, String),
}

impl Authority {
    /// Settings that trust the authority; `shows` presents its certificate, `clients` requires one.
    pub(crate) fn tls(&self, shows: bool, clients: bool) -> Tls {
        Tls {
            identity: shows.then(|| self.identity.clone()),
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
    let write = |what: &str, text: String| {
        let path = folder.join(format!("{name}-{what}.pem"));
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
fn whoever_has_no_certificate_of_the_authority_stays_outside() {
    let (home, files) = (Home::new(), tempfile::tempdir().unwrap());
    let (ours, theirs) = (authority(files.path(), "ours"), authority(files.path(), "theirs"));
    let tls = |authority: &Authority, identity: Option<&Authority>| Tls {
        identity: identity.map(|identity| identity.identity.clone()),
        authority: Some(authority.certificate.to_string_lossy().into_owned()),
        clients: true,
    };
    let own = tls(&ours, Some(&ours));
    let (_link, _, endpoint) = open(&home, "tls", |settings| settings.tls = Some(own.clone()));
    let applications = |tls| {
        let client = Client::connect(&reach(&endpoint, None, Some(tls)))?;
        client.applications()
    };
    assert_eq!(applications(own.clone()).unwrap().len(), 1);
    for (what, wrong) in [
        ("a server of another authority", tls(&theirs, Some(&ours))),
        ("a client of another authority", tls(&ours, Some(&theirs))),
        ("a client without a certificate", tls(&ours, None)),
    ] {
        let found = applications(wrong);
        assert!(
            !matches!(&found, Ok(found) if !found.is_empty()),
            "{what} gets in: {found:?}"
        );
    }
    let plain = endpoint.replace("tls/", "tcp/");
    assert!(
        Client::connect(&reach(&plain, None, None)).is_err(),
        "nor without TLS"
    );
}

#[test]
fn a_port_in_use_and_one_where_nobody_listens_are_said() {
    let home = Home::new();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let endpoint = format!("tcp/{}", taken.local_addr().unwrap());
    let mut settings = home.settings("robot");
    settings.listen = vec![endpoint.clone()];
    settings.insecure = true;
    let error = Link::open(&settings, Stage::new(), &Events::of_records())
        .err()
        .unwrap();
    assert!(
        matches!(&error, Error::Listen { endpoint: said, .. } if *said == endpoint),
        "{error}"
    );
    assert!(
        home.client().applications().unwrap().is_empty(),
        "it did not half open"
    );
    let nobody = format!("tcp/{}", free());
    let error = Client::connect(&reach(&nobody, None, None)).err().unwrap();
    assert!(
        matches!(&error, Error::Connect { endpoint, .. } if *endpoint == nobody),
        "{error}"
    );
}

#[test]
fn a_peer_of_another_version_is_named_with_both_versions() {
    let home = Home::new();
    let link = home.open("robot", &Stage::new());
    let mut about = link.about().clone();
    (about.name, about.id) = ("robot9".to_owned(), "0123456789abcdef".to_owned());
    (about.protocol, about.version) = (9, "9.9.9".to_owned());
    let path = home.folder.path().join(format!("{}.json", about.id));
    std::fs::write(&path, serde_json::to_string(&about).unwrap()).unwrap();
    let held = std::fs::File::open(&path).unwrap();
    held.lock().unwrap();
    let error = home
        .client()
        .application(Some("robot9"))
        .err()
        .unwrap()
        .to_string();
    let ours = env!("CARGO_PKG_VERSION");
    assert_eq!(
        error,
        format!(
            "`robot9` (jde 9.9.9) speaks link protocol 9, and this is protocol 1 (jde {ours}); use the same version of jde on both"
        )
    );
    drop(held);
    assert_eq!(
        home.client().applications().unwrap().len(),
        1,
        "what nobody holds is cleared away"
    );
    assert!(!path.exists());
}

/// All answers to a query.
fn answers(session: &zenoh::Session, key: &str) -> Vec<String> {
    let (tell, told) = channel();
    session
        .get(key)
        .target(zenoh::query::QueryTarget::All)
        .consolidation(zenoh::query::ConsolidationMode::None)
        .timeout(Duration::from_secs(20))
        .callback(move |reply| {
            if let Ok(sample) = reply.into_result() {
                tell.send(sample.key_expr().to_string()).unwrap();
            }
        })
        .wait()
        .unwrap();
    told.iter().collect()
}

#[test]
fn nobody_speaks_for_an_application_to_its_clients() {
    let home = Home::new();
    let (link, stage, endpoint) = open(&home, "tcp", |_| {});
    let client = Client::connect(&reach(&endpoint, None, None)).unwrap();
    let remote = client.application(None).unwrap();
    let mut writer = stage.writer("pioneer.bearing");
    write(&mut writer, 1.0, 1);
    let (_watching, told) = watch(&remote, "pioneer.bearing", Rate::Full);
    assert_eq!(number(&told.recv_timeout(SOON).unwrap()), Some(1.0));

    let (liar, puts) = (stranger(&endpoint), stranger(&endpoint));
    let root = format!("jde/1/robot/{}", link.about().id);
    let _answers = liar
        .declare_queryable("jde/**")
        .callback(|query| {
            let _ = query.reply(query.key_expr().clone(), "mine").wait();
        })
        .wait()
        .unwrap();
    let _token = liar
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
        puts.put(key, forged.clone())
            .attachment(attachment.clone())
            .wait()
            .unwrap();
    }
    // An answer implies that all earlier messages were processed.
    assert_eq!(
        answers(&puts, &format!("{root}/about")),
        [format!("{root}/about")]
    );
    write(&mut writer, 2.0, 2);
    assert_eq!(
        number(&told.recv_timeout(SOON).unwrap()),
        Some(2.0),
        "and nothing forged"
    );
    assert_eq!(client.applications().unwrap(), [link.about().clone()]);
    assert_eq!(remote.schemas().unwrap().schemas.len(), 0);
}

#[test]
fn nobody_gets_through_one_application_to_the_next() {
    let home = Home::new();
    let (link, _, endpoint) = open(&home, "tcp", |_| {});
    let _private = home.open("private", &Stage::new());
    let stranger = stranger(&endpoint);
    let about = format!("jde/1/robot/{}/about", link.about().id);
    assert_eq!(answers(&stranger, "jde/*/*/*/about"), [about]);
    assert_eq!(home.client().applications().unwrap().len(), 2);
}
