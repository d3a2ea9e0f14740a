//! Requests that concern all schemas of all applications, sent to all of them concurrently (R14). The request
//! is the first message to each application, and only its own reply counts: no query precedes it, and no
//! application delays another.

use std::collections::HashSet;
use std::sync::mpsc::{Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use parking_lot::Mutex;

use super::connection::{Connection, QueryOutcome};
use super::datagram;
use super::{REPLY_TIMEOUT, Reach, check_version, choice, keys};
use crate::folder::{Folders, Listing, RunningEntry};
use crate::keys::{OPERATE, PROTOCOL, chunk};
use crate::message::{About, Action, Request};
use crate::session::{Login, Tls};
use crate::{Error, decode};

/// How long a request without a reply is repeated: the application may still be declaring its keys, or its
/// queues may be full.
const RETRY_FOR: Duration = Duration::from_secs(2);
const RETRY_PAUSE: Duration = Duration::from_millis(50);
/// The executor's name of an application that replays a recording.
const REPLAY: &str = "replay";

/// The outcome at one application, or at an endpoint from which no application replied.
#[derive(Debug)]
pub struct BroadcastOutcome {
    /// The name of the application, or the endpoint.
    pub target: String,
    /// The affected roots.
    pub outcome: Result<Vec<String>, Error>,
}

/// Sends a request to all applications in reach, or to those of that name, and calls `report` with each
/// outcome as it arrives. An application that does not reply is reported as well.
///
/// # Errors
/// [`Error::NoApplication`], [`Error::UnknownApplication`], [`Error::NotFound`] and [`Error::OnlyRecordings`]
/// if the request applied to no application. Takes about 16 s at most.
pub fn broadcast(
    reach: &Reach,
    name: Option<&str>,
    request: &Request,
    report: &mut dyn FnMut(BroadcastOutcome),
) -> Result<(), Error> {
    Broadcast::default().send(reach, name, request, report)
}

/// A request that is sent repeatedly until every application has carried it out. An application of this machine
/// that has is not asked again, so that what another operator does to it meanwhile lasts; behind an endpoint of
/// the network, all are asked until all reply.
#[derive(Default)]
pub struct Broadcast {
    /// The ids of the applications of this machine that carried it out.
    done: Mutex<HashSet<String>>,
}

impl Broadcast {
    /// As [`broadcast`], to those that have not carried it out yet.
    ///
    /// # Errors
    /// As [`broadcast`].
    pub fn send(
        &self,
        reach: &Reach,
        name: Option<&str>,
        request: &Request,
        report: &mut dyn FnMut(BroadcastOutcome),
    ) -> Result<(), Error> {
        let message = serde_json::to_vec(request).map_err(|error| Error::Open(error.to_string()))?;
        match reach {
            Reach::Local(folders) => {
                let is_stop = request.action == Action::StopAll;
                send_local(folders, name, (&message, is_stop, &self.done), report)
            }
            Reach::Network {
                endpoints,
                login,
                tls,
            } => {
                let send = |endpoint: &String, outcomes: &Sender<BroadcastOutcome>| {
                    send_network(endpoint, (login.as_ref(), tls.as_ref()), name, &message, outcomes)
                };
                let mut count = 0;
                run_each(endpoints, send, &mut |outcome| {
                    count += 1;
                    report(outcome);
                });
                match name {
                    Some(name) if count == 0 => Err(Error::NotFound {
                        name: name.to_owned(),
                        whereabouts: format!("at {}", endpoints.join(", ")),
                    }),
                    _ => Ok(()),
                }
            }
        }
    }
}

/// Works on all targets concurrently, and calls `report` with each outcome as it arrives.
fn run_each<T: Send>(
    targets: impl IntoIterator<Item = T>,
    work: impl Fn(T, &Sender<BroadcastOutcome>) + Sync,
    report: &mut dyn FnMut(BroadcastOutcome),
) {
    let (outcomes, received) = channel();
    thread::scope(|scope| {
        for target in targets {
            let (work, outcomes) = (&work, outcomes.clone());
            scope.spawn(move || work(target, &outcomes));
        }
        drop(outcomes);
        received.iter().for_each(report);
    });
}

/// Sends the request to the applications of each folder as soon as the folder is listed. A folder that cannot
/// be listed is reported like an application, since it may contain some.
fn send_local(
    folders: &Folders,
    name: Option<&str>,
    (message, is_stop, done): (&[u8], bool, &Mutex<HashSet<String>>),
    report: &mut dyn FnMut(BroadcastOutcome),
) -> Result<(), Error> {
    let ids = || done.lock();
    let (requested, id) = choice::parts(name.unwrap_or_default());
    let is_selected = |entry: &RunningEntry| {
        entry.about.executor != REPLAY && choice::is_match(&entry.about, requested, id)
    };
    // All running applications, selected or not.
    let abouts: Mutex<Vec<About>> = Mutex::default();
    let is_new = |entry: &RunningEntry| {
        let mut abouts = abouts.lock();
        // The same folder may be found under two names.
        let known = abouts.iter().any(|about| about.id == entry.about.id);
        if !known {
            abouts.push(entry.about.clone());
        }
        !known
    };
    let send = |entry: RunningEntry, outcomes: &Sender<BroadcastOutcome>| {
        let outcome = send_to(&entry, message, is_stop);
        if outcome.is_ok() {
            ids().insert(entry.about.id);
        }
        let target = entry.about.name;
        let outcome = BroadcastOutcome { target, outcome };
        // The receiver lives until all senders are dropped.
        let _ = outcomes.send(outcome);
    };
    let send_all = |listing: Listing, outcomes: &Sender<BroadcastOutcome>| {
        let target = listing.path().display().to_string();
        match listing.wait() {
            Ok(entries) => {
                let entries = entries
                    .into_iter()
                    .filter(|entry| is_new(entry) && is_selected(entry) && !ids().contains(&entry.about.id));
                run_each(entries, send, &mut |outcome| drop(outcomes.send(outcome)));
            }
            Err(error) => {
                let outcome = Err(error);
                drop(outcomes.send(BroadcastOutcome { target, outcome }));
            }
        }
    };
    let mut reported = false;
    run_each(folders.listings(), send_all, &mut |outcome| {
        reported = true;
        report(outcome);
    });
    if reported || !ids().is_empty() {
        return Ok(());
    }
    // Names the running applications if another was requested.
    let mut abouts = abouts.into_inner();
    abouts.sort_by_key(|about| about.started_ns);
    choice::choose(&abouts.iter().collect::<Vec<_>>(), name, super::ON_THIS_MACHINE)?;
    Err(Error::OnlyRecordings)
}

/// Sends the request to an application. One that stops everything needs no connection, unless the application is older
/// than its socket for these.
fn send_to(entry: &RunningEntry, message: &[u8], is_stop: bool) -> Result<Vec<String>, Error> {
    check_version(&entry.about)?;
    if is_stop && let Ok(reply) = datagram::request(&entry.stop_socket, message) {
        return match decode::refusal(&reply) {
            Ok(refusal) => Err(refusal.into()),
            Err(_) => roots(&entry.about.name, &reply),
        };
    }
    let connection = Connection::local(entry)?;
    let key = keys(&entry.about).of(OPERATE);
    let start = Instant::now();
    loop {
        match connection.query_one(&key, Some(message.to_vec()), REPLY_TIMEOUT)? {
            QueryOutcome::Reply(reply) => return roots(&entry.about.name, &reply.message),
            QueryOutcome::Refused(refusal) => return Err(refusal.into()),
            QueryOutcome::Unanswered if start.elapsed() < RETRY_FOR => thread::sleep(RETRY_PAUSE),
            QueryOutcome::Unanswered | QueryOutcome::TimedOut => {
                return Err(Error::Timeout {
                    application: entry.about.name.clone(),
                    waited: start.elapsed(),
                });
            }
        }
    }
}

fn send_network(
    endpoint: &String,
    (login, tls): (Option<&Login>, Option<&Tls>),
    name: Option<&str>,
    message: &[u8],
    outcomes: &Sender<BroadcastOutcome>,
) {
    let report = |target: &str, outcome| {
        let target = target.to_owned();
        // The receiver lives until all senders are dropped.
        let _ = outcomes.send(BroadcastOutcome { target, outcome });
    };
    if let Err(error) = send_to_endpoint(endpoint, (login, tls), name, message, &report) {
        report(endpoint, Err(error));
    }
}

/// Receives the name of the application and its outcome.
type Report<'a> = dyn Fn(&str, Result<Vec<String>, Error>) + 'a;

/// Sends the request to all applications behind an endpoint.
fn send_to_endpoint(
    endpoint: &String,
    (login, tls): (Option<&Login>, Option<&Tls>),
    name: Option<&str>,
    message: &[u8],
    report: &Report,
) -> Result<(), Error> {
    let connection = Connection::network(endpoint, login, tls)?;
    let (requested, id) = choice::parts(name.unwrap_or_default());
    let any = |text: &str| {
        if text.is_empty() {
            "*".to_owned()
        } else {
            chunk(text)
        }
    };
    let id = if id.is_empty() {
        any(id)
    } else {
        format!("{}$*", chunk(id))
    };
    let key = format!("jde/{PROTOCOL}/{}/{id}/{OPERATE}", any(requested));
    let start = Instant::now();
    let mut replied: Vec<String> = Vec::new();
    while replied.is_empty() {
        let ended = connection.query(&key, Some(message.to_vec()), REPLY_TIMEOUT, |key, reply| {
            if replied.iter().any(|known| known == key) {
                return;
            }
            replied.push(key.to_owned());
            match reply {
                Ok(message) => {
                    let name = key.split('/').nth(2).unwrap_or(endpoint);
                    report(name, roots(name, &message));
                }
                Err(refusal) => report(endpoint, Err(refusal.into())),
            }
        })?;
        if replied.is_empty() {
            if !ended {
                return Err(Error::Timeout {
                    application: endpoint.clone(),
                    waited: start.elapsed(),
                });
            }
            if start.elapsed() >= RETRY_FOR {
                return match name {
                    // The application may be behind another endpoint.
                    Some(_) => Ok(()),
                    None => Err(Error::NoApplication(format!("at {endpoint}"))),
                };
            }
            thread::sleep(RETRY_PAUSE);
        } else if !ended {
            // One application replied; another may not have.
            return Err(Error::Timeout {
                application: endpoint.clone(),
                waited: start.elapsed(),
            });
        }
    }
    Ok(())
}

fn roots(application: &str, message: &[u8]) -> Result<Vec<String>, Error> {
    let reply = decode::operate_reply(message).map_err(|refused| Error::refused(application, refused))?;
    Ok(reply.roots)
}

#[cfg(test)]
mod tests {
    use std::fs::{self, OpenOptions, Permissions};
    use std::os::unix::fs::{OpenOptionsExt as _, PermissionsExt as _};
    use std::path::PathBuf;

    use jde_watchdog::Watchdog;
    use rustix::fs::{CWD, FileType, Mode, OFlags, mknodat};
    use zenoh::Wait;

    use super::*;
    use crate::folder::Announcement;
    use crate::keys::Keys;
    use crate::session::{SessionOptions, open};

    /// Two folders of the user. The second has an application called `robot` that confirms every request.
    struct TwoFolders {
        first: PathBuf,
        folders: Folders,
        _announced: Announcement,
        _robot: zenoh::Session,
        _files: tempfile::TempDir,
    }

    impl TwoFolders {
        fn new() -> Self {
            let files = tempfile::tempdir().unwrap();
            let [first, second] = ["first", "second"].map(|name| files.path().join(name));
            fs::create_dir(&first).unwrap();
            fs::set_permissions(&first, Permissions::from_mode(0o700)).unwrap();
            let claim = Folders::at(&second).claim("robot", true).unwrap();
            let listen = [format!("unixsock-stream/{}", claim.socket().display())];
            let robot = open(&SessionOptions {
                listen: &listen,
                ..SessionOptions::default()
            })
            .unwrap();
            robot
                .declare_queryable(Keys::new("robot", &claim.id).of(OPERATE))
                .callback(|query| {
                    let done = r#"{"ok": true, "roots": ["goon"]}"#;
                    query.reply(query.key_expr().clone(), done).wait().unwrap();
                })
                .background()
                .wait()
                .unwrap();
            let about = crate::folder::runtime_folder::tests::about("robot", &claim.id);
            Self {
                folders: Folders::several([first.clone(), second]),
                first,
                _announced: claim.announce(&about).unwrap(),
                _robot: robot,
                _files: files,
            }
        }

        /// Stops everything, and returns the outcomes in their order of arrival.
        fn stop_all(&self) -> Vec<(String, Result<Vec<String>, String>)> {
            let stop = Request {
                by: "ana".to_owned(),
                action: Action::StopAll,
                lease_ms: None,
            };
            let mut outcomes = Vec::new();
            broadcast(&Reach::Local(self.folders.clone()), None, &stop, &mut |outcome| {
                outcomes.push((outcome.target, outcome.outcome.map_err(|error| error.to_string())));
            })
            .unwrap();
            outcomes
        }
    }

    fn robot() -> (String, Result<Vec<String>, String>) {
        ("robot".to_owned(), Ok(vec!["goon".to_owned()]))
    }

    #[test]
    fn r14_a_folder_that_does_not_respond_is_reported_and_delays_no_application() {
        let _watchdog = Watchdog::for_test();
        let folders = TwoFolders::new();
        // Opening a fifo to read waits for a writer, as a network file system may block.
        let hung = folders.first.join("hung");
        mknodat(CWD, &hung, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        let outcomes = folders.stop_all();
        assert_eq!(outcomes[0], robot());
        let (target, error) = &outcomes[1];
        assert_eq!(*target, folders.first.display().to_string());
        assert!(
            error.as_ref().unwrap_err().contains("cannot be listed within"),
            "{error:?}"
        );
        // Opening the other end lets the waiting thread finish.
        let nonblock = OFlags::NONBLOCK.bits().cast_signed();
        let _end = OpenOptions::new()
            .write(true)
            .custom_flags(nonblock)
            .open(hung)
            .unwrap();
    }

    #[test]
    fn r14_an_unlisted_folder_is_reported_if_the_user_owns_it() {
        let _watchdog = Watchdog::for_test();
        let folders = TwoFolders::new();
        fs::set_permissions(&folders.first, Permissions::from_mode(0o755)).unwrap();
        let mut outcomes = folders.stop_all();
        outcomes.sort_by_key(|(target, _)| target == "robot");
        assert_eq!(outcomes[1], robot());
        assert_eq!(outcomes[0].0, folders.first.display().to_string());
        assert!(
            outcomes[0].1.as_ref().unwrap_err().contains("chmod 700"),
            "{outcomes:?}"
        );
        fs::remove_dir(&folders.first).unwrap();
        fs::write(&folders.first, "").unwrap();
        assert_eq!(folders.stop_all(), [robot()]);
    }
}
