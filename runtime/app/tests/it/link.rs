//! The settings of `[link]`, and the faults of a link that would admit or trust unauthenticated peers.

use std::path::{Path, PathBuf};

use jde_app::link::{Access, Identity, Link, Login, Tls};
use jde_app::{Application, Faults, parse};

use crate::catalogue::{DescribedPlugins, GOOD, application, check};

/// The line of the good application before which a test inserts `[link]`.
const SCHEMAS: &str = "[schemas.pioneer]";

/// A folder with the files that a link can name.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["robot.pem", "robot.key", "ca.pem", "link.password"] {
        std::fs::write(folder.path().join(name), "made up\n").expect("a file");
    }
    folder
}

/// Reads the good application with a link, as if the file were in `folder`.
fn read(folder: &Path, link: &str) -> Result<Application, Faults> {
    let text = GOOD.replace(SCHEMAS, &format!("[link]\n{link}\n{SCHEMAS}"));
    assert_ne!(text, GOOD, "the good application has no `{SCHEMAS}`");
    parse(&text, &folder.join("app.toml"), &[], &DescribedPlugins)
}

fn linked(folder: &Path, link: &str) -> Link {
    read(folder, link)
        .unwrap_or_else(|faults| panic!("{faults}"))
        .link
}

/// Returns the faults of a link, without lines and columns, which other tests of applications check.
fn messages(folder: &Path, link: &str) -> Vec<String> {
    let faults = read(folder, link).expect_err(link);
    let list = faults.list().iter();
    list.map(|fault| {
        assert!(fault.line().is_some(), "{fault}");
        let shown = folder.display().to_string();
        fault.message.replace(&shown, "FOLDER")
    })
    .collect()
}

#[test]
fn without_a_link_section_no_address_is_opened() {
    let link = application(&[]).link;
    assert_eq!(link, Link::local("safe-navigation"));
    assert!(link.listen.is_empty() && link.connect.is_empty() && !link.discover && !link.off);
    assert!(!link.is_open());
}

#[test]
fn all_settings_of_a_link_are_read() {
    let folder = folder();
    let path = |name: &str| -> PathBuf { folder.path().join(name) };
    let link = linked(
        folder.path(),
        r#"
        name = "robot2"
        listen = ["tls/0.0.0.0:7447", "tls/[::1]:0"]
        connect = ["tls/base.local:7447"]
        discover = true
        access = "read"
        user = "lab"
        password-file = "link.password"
        tls = { certificate = "robot.pem", key = "robot.key", authority = "ca.pem", clients = false }
        stale = "300ms"
        insecure = false
        off = false
        "#,
    );
    assert!(link.is_open());
    assert_eq!(
        link,
        Link {
            name: "robot2".to_owned(),
            listen: vec!["tls/0.0.0.0:7447".to_owned(), "tls/[::1]:0".to_owned()],
            connect: vec!["tls/base.local:7447".to_owned()],
            discover: true,
            access: Access::Read,
            login: Some(Login {
                user: "lab".to_owned(),
                password_file: path("link.password"),
            }),
            tls: Some(Tls {
                identity: Some(Identity {
                    certificate: path("robot.pem"),
                    key: path("robot.key"),
                }),
                authority: Some(path("ca.pem")),
                clients: false,
            }),
            stale_ns: 300_000_000,
            insecure: false,
            off: false,
        }
    );
}

#[test]
fn the_name_of_a_link_defaults_to_that_of_the_application() {
    for (application, link) in [
        ("safe-navigation", "safe-navigation"),
        ("Follow the ball!", "Follow-the-ball-"),
        ("", "application"),
        ("año", "a-o"),
    ] {
        assert_eq!(Link::local(application).name, link);
        assert!(Link::is_name(link));
    }
    let folder = folder();
    assert_eq!(
        messages(folder.path(), r#"name = "robot 2""#),
        ["`robot 2` cannot be the name of a link"]
    );
}

#[test]
fn an_address_on_this_machine_is_refused_unless_insecure() {
    let folder = folder();
    let listen = r#"listen = ["tcp/127.0.0.1:7447", "tcp/localhost:0", "unixsock-stream/robot"]"#;
    let open = |address: &str| {
        format!("`listen` of `link` has `{address}`, where every user of this machine may connect")
    };
    assert_eq!(
        messages(folder.path(), listen),
        ["tcp/127.0.0.1:7447", "tcp/localhost:0", "unixsock-stream/robot"].map(open)
    );
    let link = linked(folder.path(), &format!("{listen}\ninsecure = true"));
    assert!(!link.is_open());
    let socket = format!("unixsock-stream/{}", folder.path().join("robot").display());
    assert_eq!(link.listen[2], socket);
}

/// Forms of `tls`: only a certificate; with client certificates required; with an authority but without
/// client certificates.
const CERTIFICATE_ONLY: &str = r#"tls = { certificate = "robot.pem", key = "robot.key" }"#;
const REQUIRES_CERTIFICATES: &str =
    r#"tls = { certificate = "robot.pem", key = "robot.key", authority = "ca.pem" }"#;
const AUTHORITY_WITHOUT_CLIENTS: &str =
    r#"tls = { certificate = "robot.pem", key = "robot.key", authority = "ca.pem", clients = false }"#;
const LOGIN: &str = "user = \"lab\"\npassword-file = \"link.password\"";
const TLS: &str = r#"listen = ["tls/0.0.0.0:7447"]"#;
const TCP: &str = r#"listen = ["tcp/0.0.0.0:7447"]"#;

#[test]
fn an_address_open_to_unauthenticated_clients_is_refused_unless_insecure() {
    let folder = folder();
    let open = |address: &str| {
        format!("`listen` of `link` has `{address}`, where any machine on the network may connect")
    };
    assert_eq!(
        messages(
            folder.path(),
            r#"listen = ["tcp/0.0.0.0:7447", "tcp/robot:7449"]"#
        ),
        [open("tcp/0.0.0.0:7447"), open("tcp/robot:7449")]
    );
    // The application's own certificate restricts no client. Client certificates on one address do not
    // protect another address.
    for refused in [
        format!("{TLS}\n{CERTIFICATE_ONLY}"),
        format!("{TLS}\n{AUTHORITY_WITHOUT_CLIENTS}"),
    ] {
        assert_eq!(messages(folder.path(), &refused), [open("tls/0.0.0.0:7447")]);
    }
    let both = r#"listen = ["tls/0.0.0.0:7447", "tcp/0.0.0.0:7448"]"#;
    assert_eq!(
        messages(folder.path(), &format!("{both}\n{REQUIRES_CERTIFICATES}")),
        [open("tcp/0.0.0.0:7448")]
    );
    for guarded in [
        format!("{TLS}\n{REQUIRES_CERTIFICATES}"),
        format!("{TLS}\n{AUTHORITY_WITHOUT_CLIENTS}\n{LOGIN}"),
        format!("{TCP}\ninsecure = true"),
        format!("{TLS}\n{CERTIFICATE_ONLY}\ninsecure = true"),
    ] {
        let link = linked(folder.path(), &guarded);
        assert!(link.is_open(), "{guarded}");
        assert!(!linked(folder.path(), &format!("{guarded}\noff = true")).is_open());
    }
}

#[test]
fn a_connection_to_an_unauthenticated_peer_is_refused_unless_insecure() {
    let folder = folder();
    for address in ["tcp/base:7447", "tcp/127.0.0.1:7447", "tls/base:7447"] {
        let connect = format!("connect = [\"{address}\"]");
        assert_eq!(
            messages(folder.path(), &connect),
            [format!(
                "`connect` of `link` has `{address}`, and its peer is not authenticated"
            )]
        );
        assert!(linked(folder.path(), &format!("{connect}\ninsecure = true")).insecure);
    }
    // An authority that verifies clients of one address does not verify the peer of another.
    let mixed = format!("{TLS}\nconnect = [\"tcp/base:7447\"]\n{REQUIRES_CERTIFICATES}");
    assert_eq!(messages(folder.path(), &mixed).len(), 1);
    linked(
        folder.path(),
        "connect = [\"tls/base:7447\"]\ntls = { authority = \"ca.pem\" }",
    );
}

#[test]
fn a_password_requires_tls_with_an_authority() {
    let folder = folder();
    let message = |key: &str, address: &str| {
        format!(
            "`{key}` of `link` has `{address}`, where the password could reach an unauthenticated peer or be intercepted"
        )
    };
    for insecure in ["", "\ninsecure = true"] {
        for (link, key, address) in [
            (TCP.to_owned(), "listen", "tcp/0.0.0.0:7447"),
            (format!("{TLS}\n{CERTIFICATE_ONLY}"), "listen", "tls/0.0.0.0:7447"),
            (
                format!("connect = [\"tcp/base:7447\"]\n{REQUIRES_CERTIFICATES}"),
                "connect",
                "tcp/base:7447",
            ),
        ] {
            let link = format!("{link}\n{LOGIN}{insecure}");
            assert_eq!(messages(folder.path(), &link), [message(key, address)], "{link}");
        }
    }
}

#[test]
fn a_secret_file_that_other_users_can_read_causes_a_warning() {
    use std::os::unix::fs::PermissionsExt as _;

    let folder = folder();
    let link = format!("{TLS}\n{AUTHORITY_WITHOUT_CLIENTS}\n{LOGIN}");
    let warnings_with_mode = |mode: u32| {
        for secret in ["link.password", "robot.key"] {
            let mode = std::fs::Permissions::from_mode(mode);
            std::fs::set_permissions(folder.path().join(secret), mode).expect("the test owns the file");
        }
        read(folder.path(), &link).expect("no fault").warnings()
    };
    assert_eq!(warnings_with_mode(0o600), [""; 0]);
    for mode in [0o640, 0o604] {
        let warnings = warnings_with_mode(mode);
        assert_eq!(warnings.len(), 2, "{warnings:?}");
        assert!(warnings[0].contains("can read the password in") && warnings[0].contains("link.password"));
        assert!(warnings[1].contains("can read the key in") && warnings[1].contains("chmod 600"));
    }
}

#[test]
fn an_authority_requires_client_certificates_by_default() {
    let folder = folder();
    let clients = |tls: &str| linked(folder.path(), tls).tls.expect(tls).clients;
    assert!(clients(r#"tls = { authority = "ca.pem" }"#));
    assert!(!clients(r#"tls = { authority = "ca.pem", clients = false }"#));
    assert!(!clients(
        r#"tls = { certificate = "robot.pem", key = "robot.key" }"#
    ));
}

#[test]
fn a_missing_or_invalid_setting_is_reported() {
    let folder = folder();
    for (link, expected) in [
        (r#"user = "lab""#, "`user` of `link` requires `password-file`"),
        (
            r#"password-file = "link.password""#,
            "`password-file` of `link` requires `user`",
        ),
        (
            r#"tls = { certificate = "robot.pem" }"#,
            "`certificate` of `tls` of `link` requires `key`",
        ),
        (
            r#"tls = { key = "robot.key" }"#,
            "`key` of `tls` of `link` requires `certificate`",
        ),
        (
            r#"tls = { clients = true }"#,
            "`clients` of `tls` of `link` requires `authority`",
        ),
        (
            "listen = [\"tls/localhost:7447\"]\ninsecure = true",
            "`listen` of `link` has `tls/localhost:7447`, and the link has no certificate to present there",
        ),
        (
            r#"discover = true"#,
            "`discover` of `link` discovers only on the networks where it listens, and it listens on none",
        ),
        (
            "connect = [\"tcp/base:0\"]\ninsecure = true",
            "`connect` of `link` has no port to connect to",
        ),
        (
            "user = \"la:b\"\npassword-file = \"link.password\"",
            "`la:b` cannot be the name of a user",
        ),
        (
            "user = \"lab\"\npassword-file = \"link.pasword\"",
            "`password-file` of `link` is `FOLDER/link.pasword`, and there is no such file",
        ),
        (
            r#"tls = { authority = "." }"#,
            "`authority` of `tls` of `link` is `FOLDER/.`, which is not a file",
        ),
    ] {
        assert_eq!(messages(folder.path(), link), [expected], "{link}");
    }
}

#[test]
fn a_misspelt_setting_is_reported_with_the_intended_one() {
    check(
        &[(
            SCHEMAS,
            r#"
[link]
lisen = []
acces = "read"
access = "reed"
connect = ["tpc/base:7447", "base", "tcp/base:77777"]
discover = "yes"
tls = { certificat = "robot.pem" }
stale = "3 km"
[schemas.pioneer]"#,
        )],
        r#"
apps/good.toml:8:1: unknown key `lisen` in `link`
    help: did you mean `listen`?
apps/good.toml:9:1: unknown key `acces` in `link`
    help: did you mean `access`?
apps/good.toml:10:10: `access` of `link` is `reed`, which is not an access
    help: did you mean `read`?
apps/good.toml:11:12: `connect` of `link` has `tpc/base:7447`, and there is no protocol `tpc`
    help: did you mean `tcp`?
apps/good.toml:11:29: `connect` of `link` has `base`, which is not an address
    help: write an address such as "tls/0.0.0.0:7447" or "tcp/robot.local:7447"
apps/good.toml:11:37: `connect` of `link` has `tcp/base:77777`, which has no port up to 65535
    help: write an address such as "tls/0.0.0.0:7447" or "tcp/robot.local:7447"
apps/good.toml:12:12: `discover` of `link` must be true or false, not a text
apps/good.toml:13:9: unknown key `certificat` in `tls` of `link`
    help: did you mean `certificate`?
apps/good.toml:14:9: `stale` of `link` must be a time, and `km` is no unit of time
    help: write a time such as "75ms", or a number of seconds
"#,
    );
}
