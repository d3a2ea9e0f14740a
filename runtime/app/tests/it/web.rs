//! The settings of a page for browsers, in the section `[web]` and in files of their own.

use std::path::Path;

use jde_app::link::Access;
use jde_app::{Application, Faults, Web, parse};

use crate::catalogue::{DescribedPlugins, GOOD};

/// The line of the good application before which a test inserts `[web]`.
const SCHEMAS: &str = "[schemas.pioneer]";

fn section(text: &str) -> Result<Application, Faults> {
    let text = GOOD.replace(SCHEMAS, &format!("[web]\n{text}\n{SCHEMAS}"));
    parse(&text, Path::new("/robot/app.toml"), &[], &DescribedPlugins)
}

fn read(text: &str) -> Web {
    let read = section(text).unwrap_or_else(|faults| panic!("{faults}"));
    read.web.expect("there is a section")
}

fn fault(text: &str) -> String {
    section(text).map(|_| ()).expect_err(text).to_string()
}

#[test]
fn without_the_section_there_is_no_page_and_an_empty_one_is_for_this_machine() {
    assert_eq!(
        parse(GOOD, Path::new("/app.toml"), &[], &DescribedPlugins)
            .unwrap()
            .web,
        None
    );
    assert_eq!(read(""), Web::default());
    assert_eq!(
        read("listen = \"127.0.0.1:80\"").listen,
        Some("127.0.0.1:80".parse().unwrap())
    );
    assert_eq!(read("access = \"read\"").access, Access::Read);
}

#[test]
fn the_network_needs_tls_or_a_word() {
    let open = "listen = \"0.0.0.0:7480\"";
    assert!(fault(open).contains("without TLS"), "{}", fault(open));
    assert!(fault("listen = \"[::]:7480\"").contains("without TLS"));
    read(&format!("{open}\ninsecure = true"));
    // The file of a recording names what only the robot has.
    let tls = read(&format!(
        "{open}\ntls = {{ certificate = \"robot.pem\", key = \"robot.key\" }}"
    ))
    .tls;
    assert_eq!(
        tls.expect("it is stated").certificate,
        Path::new("/robot/robot.pem")
    );
    assert!(fault("tls = { key = \"robot.key\" }").contains("certificate"));
}

#[test]
fn origins_are_whole() {
    let origins = |list: &str| format!("origins = [{list}]");
    let web = read(&origins(
        "\"https://app.foxglove.dev\", \"http://lab:8080\", \"file://\"",
    ));
    assert_eq!(web.origins.len(), 3);
    for wrong in [
        "*",
        "null",
        "https://*",
        "app.foxglove.dev",
        "https://app.foxglove.dev/",
        "file:///home",
        "",
    ] {
        assert!(
            fault(&origins(&format!("\"{wrong}\""))).contains("no origin of a page"),
            "{wrong}"
        );
    }
}

#[test]
fn names_are_whole_and_mistakes_have_a_place() {
    let hosts = |list: &str| format!("hosts = [{list}]");
    read(&hosts("\"robot.local\", \"robot.local:8443\""));
    for wrong in [
        "*",
        "*.local",
        "http://robot.local",
        "robot.local/",
        "",
        "a:b",
        "a:0",
        "::1",
    ] {
        assert!(
            fault(&hosts(&format!("\"{wrong}\""))).contains("no name of a host"),
            "{wrong}"
        );
    }
    assert!(fault("listen = \"robot:80\"").contains("which is no number with a port"));
    assert!(fault("acces = \"read\"").contains("did you mean `access`"));
}

#[test]
fn a_file_of_its_own_has_the_same_keys_and_its_files_exist() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("page.toml");
    let read = |text: &str| {
        std::fs::write(&file, text).expect("a file");
        Web::read_file(&file).map_err(|faults| faults.to_string())
    };
    assert_eq!(
        read("access = \"read\"").expect("it is right").access,
        Access::Read
    );
    let missing =
        read("\ntls = { certificate = \"none.pem\", key = \"none.key\" }").expect_err("it is missing");
    assert!(
        missing.contains("page.toml:2:") && missing.contains("none.pem"),
        "{missing}"
    );
}
