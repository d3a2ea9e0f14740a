//! Selects the application of a verb and the connection to it.

use std::cell::RefCell;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use clap_complete::ArgValueCompleter;
use jde_link::{Client, Folders, Login, Reach, Remote, Tls, Unanswered, complete_endpoint};
use jde_session::log::Log;
use serde::Deserialize;

use crate::complete;
use crate::failure::Failure;
use crate::quantity;

/// The application, and where it runs.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct Target {
    /// The application, if several run. A name may contain it too, as in robot2:goon.
    #[arg(short, long, env = "JDE_APP", value_name = "NAME", add = ArgValueCompleter::new(complete::applications))]
    pub(crate) app: Option<String>,
    /// Look for it at this endpoint instead of on this machine, such as tcp/robot2:7447 or tls/robot2:7447
    /// (repeatable).
    #[arg(
        long,
        env = "JDE_AT",
        value_name = "ENDPOINT",
        allow_hyphen_values = true,
        value_delimiter = ','
    )]
    pub(crate) at: Vec<String>,
    /// The credentials: a file with user and password-file, or tls, as in an application that opens its link.
    #[arg(long, env = "JDE_KEY", value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) key: Option<PathBuf>,
    /// Whether it is a recording that this process serves. The defaults, which are of running applications, do
    /// not apply to it.
    #[arg(skip)]
    pub(crate) is_recording: bool,
}

impl Target {
    /// The application, if it was typed and is not only set in the environment.
    pub(crate) fn typed_app(&self) -> Option<&str> {
        let default = std::env::var("JDE_APP").ok();
        self.app.as_deref().filter(|app| Some(*app) != default.as_deref())
    }

    /// Its options without the application, for another process of this program.
    pub(crate) fn link_options(&self) -> Vec<OsString> {
        let endpoints = self.at.iter().map(|endpoint| format!("--at={endpoint}").into());
        let key = self.key.iter().map(|key| {
            let mut option = OsString::from("--key=");
            option.push(key);
            option
        });
        endpoints.chain(key).collect()
    }

    /// Whether an endpoint was typed, and is not only set in the environment.
    pub(crate) fn has_typed_endpoint(&self) -> bool {
        let default = std::env::var("JDE_AT").unwrap_or_default();
        !self.at.is_empty() && !self.at.iter().map(String::as_str).eq(default.split(','))
    }
}

/// What consecutive verbs share: the connection, and the defaults for the application.
#[derive(Default)]
pub(crate) struct Context {
    /// The defaults for options that are not given. `jde shell` sets them.
    pub(crate) target: RefCell<Target>,
    /// The last application, with the options that selected it.
    cached: RefCell<Option<(Selector, Remote)>>,
    /// The endpoints and applications that gave no answer when it was looked for.
    unanswered: RefCell<Vec<String>>,
    /// The log of this process.
    pub(super) log: Option<Log>,
}

/// The options that select an application: name, endpoints, key file.
type Selector = (Option<String>, Vec<String>, Option<PathBuf>);

/// The content of a key file.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct Key {
    user: Option<String>,
    password_file: Option<PathBuf>,
    tls: Option<KeyTls>,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct KeyTls {
    certificate: Option<PathBuf>,
    key: Option<PathBuf>,
    authority: Option<PathBuf>,
}

/// Returns the failure of a verb for running applications that got a file.
pub(super) fn recording_instead(file: &str) -> Failure {
    Failure::usage(
        format!("`{file}` is a file; this verb is for a running application"),
        format!("use `jde info {file}`, `jde report {file}` or `jde why --in {file}` for a recording"),
    )
}

impl Context {
    /// Creates a context with the log of this process.
    pub(crate) fn new(log: Log) -> Self {
        Self {
            log: Some(log),
            ..Self::default()
        }
    }

    /// Refuses success to a verb that looked for its application where something gave no answer.
    ///
    /// # Errors
    /// Names what gave no answer. The reasons are in the log.
    pub(super) fn check_answers(&self) -> Result<(), Failure> {
        let unanswered = self.unanswered.take();
        if unanswered.is_empty() {
            return Ok(());
        }
        Err(Failure::broken(format!(
            "{} gave no usable answer",
            unanswered.join(", ")
        )))
    }

    /// Connects a client that looks for applications.
    pub(crate) fn client(&self, target: &Target) -> Result<Client, Failure> {
        let (_, at, key) = self.selector(target, None);
        Ok(Client::connect(&reach(&at, key.as_deref())?)?)
    }

    /// Returns the name of the chosen application, if there is one.
    pub(crate) fn application_name(&self, target: &Target) -> Option<String> {
        self.selector(target, None).0
    }

    /// Returns where to look for applications.
    pub(crate) fn reach(&self, target: &Target) -> Result<Reach, Failure> {
        let (_, at, key) = self.selector(target, None);
        reach(&at, key.as_deref())
    }

    /// Connects to the chosen application. `named` is the part of a name before its colon.
    pub(crate) fn remote(&self, target: &Target, named: Option<&str>) -> Result<Remote, Failure> {
        let selector = self.selector(target, named);
        if let Some((previous, remote)) = &*self.cached.borrow()
            && *previous == selector
            && remote.is_alive()
        {
            return Ok(remote.clone());
        }
        let (app, at, key) = &selector;
        let client = Client::connect(&reach(at, key.as_deref())?)?;
        let remote = client.application(app.as_deref()).map_err(|error| match named {
            Some(named) if Path::new(named).is_file() => recording_instead(named),
            _ => error.into(),
        })?;
        for Unanswered { target, reason } in client.unanswered() {
            tracing::warn!("{reason}");
            self.unanswered.borrow_mut().push(target);
        }
        *self.cached.borrow_mut() = Some((selector, remote.clone()));
        Ok(remote)
    }

    fn selector(&self, target: &Target, named: Option<&str>) -> Selector {
        if target.is_recording {
            return (target.app.clone(), Vec::new(), None);
        }
        let defaults = self.target.borrow();
        let at = if target.at.iter().all(String::is_empty) {
            &defaults.at
        } else {
            &target.at
        };
        (
            named
                .map(str::to_owned)
                .or_else(|| target.app.clone())
                .or_else(|| defaults.app.clone()),
            // An empty environment variable counts as unset.
            at.iter()
                .filter(|endpoint| !endpoint.is_empty())
                .cloned()
                .collect(),
            target
                .key
                .clone()
                .or_else(|| defaults.key.clone())
                .filter(|key| !key.as_os_str().is_empty()),
        )
    }
}

fn reach(at: &[String], key: Option<&Path>) -> Result<Reach, Failure> {
    if at.is_empty() {
        if let Some(key) = key {
            return Err(Failure::usage(
                format!(
                    "{} is for a connection over the network, and no endpoint is given",
                    key.display()
                ),
                "give one: --at tls/robot2:7447; on this machine no key is needed",
            ));
        }
        return Ok(Reach::Local(Folders::of_user()));
    }
    if let Some(time) = at
        .iter()
        .find(|endpoint| quantity::is_time(endpoint) || quantity::is_time_of_day(endpoint))
    {
        return Err(Failure::usage(
            format!("`{time}` is a time, and --at without --in is the endpoint of an application"),
            "a time needs --in FILE, which get, ps, vars and events have: jde ps --in drive.mcap --at 12.4s",
        ));
    }
    let (login, tls) = key.map_or(Ok((None, None)), read_key)?;
    Ok(Reach::Network {
        endpoints: at.iter().map(|endpoint| complete_endpoint(endpoint)).collect(),
        login,
        tls,
    })
}

/// The largest file of a key, bytes.
const MAX_KEY: u64 = 64 << 10;

fn read_key(file: &Path) -> Result<(Option<Login>, Option<Tls>), Failure> {
    let text = jde_files::read_text(file, MAX_KEY).map_err(Failure::file(file))?;
    let key: Key = toml::from_str(&text).map_err(|error| {
        Failure::usage(
            format!("{}: {}", file.display(), error.message()),
            "it contains user and password-file, or tls = { authority = \"ca.pem\", certificate = \"me.pem\", key = \"me.key\" }",
        )
    })?;
    let folder = file.parent().unwrap_or(Path::new("."));
    let path = |path: &PathBuf| folder.join(path).to_string_lossy().into_owned();
    let login = match (&key.user, &key.password_file) {
        (Some(user), Some(password)) => Some(Login::read(user, &folder.join(password))?),
        (None, None) => None,
        (Some(_), None) | (None, Some(_)) => {
            return Err(Failure::usage(
                format!("{}: user and password-file belong together", file.display()),
                "give both, or neither",
            ));
        }
    };
    let tls = key.tls.as_ref().map(|tls| Tls {
        identity: tls.certificate.as_ref().map(path).zip(tls.key.as_ref().map(path)),
        authority: tls.authority.as_ref().map(path),
        clients: false,
    });
    Ok((login, tls))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::failure::RunFailure;

    #[test]
    fn a_time_without_a_recording_is_no_endpoint() {
        for time in ["30s", "12.4", "-5s"] {
            let Err(Failure::Run(RunFailure::Usage { message, help })) = reach(&[time.to_owned()], None)
            else {
                panic!("{time} is refused");
            };
            assert!(
                message.contains("is a time") && help.contains("--in"),
                "{message}"
            );
        }
        assert!(reach(&["robot2:7447".to_owned()], None).is_ok());
    }

    #[test]
    fn a_recording_is_looked_for_on_this_machine_whatever_the_defaults_are() {
        let context = Context::default();
        *context.target.borrow_mut() = Target {
            at: vec!["tcp/robot2:7447".to_owned()],
            key: Some(PathBuf::from("key.toml")),
            ..Target::default()
        };
        let mut target = Target {
            app: Some("drive-7".to_owned()),
            ..Target::default()
        };
        assert_eq!(context.selector(&target, None).1, ["tcp/robot2:7447"]);
        target.is_recording = true;
        let selector = (Some("drive-7".to_owned()), Vec::new(), None);
        assert_eq!(context.selector(&target, None), selector);
    }

    #[test]
    fn a_key_file_refers_to_files_in_its_folder_and_has_no_other_keys() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("key.toml");
        fs::write(folder.path().join("password"), "secret\r\nfor the lab\n").unwrap();
        fs::write(&file, "user = \"lab\"\npassword-file = \"password\"\n").unwrap();
        let (login, tls) = read_key(&file).unwrap();
        let login = login.unwrap();
        assert_eq!((login.user.as_str(), login.password.as_str()), ("lab", "secret"));
        assert!(tls.is_none());
        fs::write(&file, "usr = \"lab\"\n").unwrap();
        assert!(read_key(&file).is_err());
        fs::write(&file, "user = \"lab\"\n").unwrap();
        assert!(read_key(&file).is_err());
    }
}
