//! The file of `--web=FILE` and `jde web --page FILE`: where the page listens, under which names, and who may do what. It
//! refuses to open the network by accident, as the link does.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use jde_web::{Identity, Right, Settings};
use serde::Deserialize;

use crate::failure::Failure;

/// The largest file, bytes.
const MAX_FILE: u64 = 64 << 10;

/// What the file states.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct PageFile {
    listen: Option<SocketAddr>,
    #[serde(default)]
    hosts: Vec<String>,
    access: Option<Right>,
    tls: Option<Tls>,
    #[serde(default)]
    insecure: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Tls {
    certificate: PathBuf,
    key: PathBuf,
}

/// Reads the settings of a page; without a file those for this machine alone.
///
/// # Errors
/// The file cannot be read, or would let others read along.
pub(crate) fn read(file: Option<&Path>) -> Result<Settings, Failure> {
    let Some(file) = file else {
        return Ok(Settings::local());
    };
    let text = jde_files::read_text(file, MAX_FILE).map_err(Failure::file(file))?;
    let folder = file.parent().unwrap_or(Path::new("."));
    parse(&text, folder).map_err(|(what, help)| Failure::usage(format!("{}: {what}", file.display()), help))
}

fn parse(text: &str, folder: &Path) -> Result<Settings, (String, &'static str)> {
    let page: PageFile = toml::from_str(text).map_err(|error| {
        let before = error.span().map_or("", |span| text.get(..span.start).unwrap_or_default());
        (
            format!("line {}: {}", before.matches('\n').count() + 1, error.message()),
            "it contains listen = \"0.0.0.0:7480\", hosts, access, tls = { certificate = \"robot.pem\", key = \"robot.key\" }, insecure",
        )
    })?;
    let is_network = page
        .listen
        .is_some_and(|at| !at.ip().to_canonical().is_loopback());
    if is_network && page.tls.is_none() && !page.insecure {
        return Err((
            "the page would be on the network without TLS, where others can read the token".to_owned(),
            "add tls = { certificate = \"robot.pem\", key = \"robot.key\" }, or write insecure = true on a network of your own",
        ));
    }
    if let Some(host) = page.hosts.iter().find(|host| !is_host(host)) {
        return Err((
            format!("`{host}` is no name of a host"),
            "write names such as \"robot.local\", or \"robot.local:8443\" if browsers use another port",
        ));
    }
    Ok(Settings {
        listen: page.listen,
        hosts: page.hosts,
        access: page.access.unwrap_or(Right::Operate),
        tls: page.tls.map(|tls| Identity {
            certificate: folder.join(tls.certificate),
            key: folder.join(tls.key),
        }),
    })
}

/// Whether a text is a name with or without a port; no pattern is one.
fn is_host(text: &str) -> bool {
    let (name, port) = text.split_once(':').unwrap_or((text, "1"));
    let is_letter = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'.' | b'_');
    !name.is_empty() && name.bytes().all(is_letter) && port.parse::<u16>().is_ok_and(|port| port > 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Settings, String> {
        parse(text, Path::new("robot")).map_err(|(what, _)| what)
    }

    #[test]
    fn without_more_the_page_is_for_this_machine_alone() {
        assert_eq!(super::read(None).unwrap(), Settings::local());
        assert_eq!(read("").unwrap(), Settings::local());
        assert_eq!(
            read("listen = \"127.0.0.1:80\"").unwrap().listen,
            Some("127.0.0.1:80".parse().unwrap())
        );
    }

    #[test]
    fn the_network_needs_tls_or_a_word() {
        let open = "listen = \"0.0.0.0:7480\"";
        assert!(read(open).unwrap_err().contains("without TLS"));
        assert!(read("listen = \"[::]:7480\"").is_err());
        assert!(read(&format!("{open}\ninsecure = true")).is_ok());
        let tls = "tls = { certificate = \"robot.pem\", key = \"robot.key\" }";
        let tls = read(&format!("{open}\n{tls}")).unwrap().tls.unwrap();
        assert_eq!(tls.certificate, Path::new("robot/robot.pem"));
    }

    #[test]
    fn names_are_whole_and_mistakes_have_a_line() {
        let hosts = |list: &str| read(&format!("hosts = [{list}]"));
        assert!(hosts("\"robot.local\", \"robot.local:8443\"").is_ok());
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
            assert!(hosts(&format!("\"{wrong}\"")).is_err(), "{wrong}");
        }
        assert!(
            read("access = \"read\"\nlisten = \"robot:80\"")
                .unwrap_err()
                .starts_with("line 2: ")
        );
        assert!(read("acces = \"read\"").unwrap_err().starts_with("line 1: "));
    }
}
