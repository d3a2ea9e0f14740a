//! Requests that concern all schemas of all applications, sent to all of them concurrently (R14). The order
//! is the first message to each application, and only its own answer counts: no query precedes it, and no
//! application delays another.

use std::sync::mpsc::{Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::connection::{Connection, QueryOutcome};
use super::{REPLY_TIMEOUT, Reach, check_version, choice, keys};
use crate::Error;
use crate::folder::{Entry, Folders, Listing};
use crate::keys::{OPERATE, PROTOCOL, chunk};
use crate::message::{About, OperateReply, Request};
use crate::session::{Login, Tls};

/// How long an order without an answer is repeated: the application may still be declaring its keys, or have
/// no room.
const RETRY_FOR: Duration = Duration::from_secs(2);
const RETRY_PAUSE: Duration = Duration::from_millis(50);
/// The executor's name of an application that replays a recording.
const REPLAY: &str = "replay";

/// The outcome at one application, or at an endpoint that no application answered from.
#[derive(Debug)]
pub struct BroadcastOutcome {
    /// The name of the application, or the endpoint.
    pub target: String,
    /// The affected roots.
    pub outcome: Result<Vec<String>, Error>,
}

/// Sends a request to all applications in reach, or to those of that name, and calls `tell` with each outcome
/// as it arrives. An application that does not answer is reported as well.
///
/// # Errors
/// [`Error::NoApplication`], [`Error::UnknownApplication`], [`Error::NotFound`] and [`Error::OnlyRecordings`]
/// if the request applied to no application. Takes about 16 s at most.
pub fn broadcast(
    reach: &Reach,
    name: Option<&str>,
    request: &Request,
    tell: &mut dyn FnMut(BroadcastOutcome),
) -> Result<(), Error> {
    let order = serde_json::to_vec(request).map_err(|error| Error::Open(error.to_string()))?;
    match reach {
        Reach::Local(folders) => send_local(folders, name, &order, tell),
        Reach::Network {
            endpoints,
            login,
            tls,
        } => {
            let there = |endpoint: &String, told: &Sender<BroadcastOutcome>| {
                send_network(endpoint, (login.as_ref(), tls.as_ref()), name, &order, told)
            };
            let mut heard = 0;
            run_each(endpoints, there, &mut |what| {
                heard += 1;
                tell(what);
            });
            match name {
                Some(name) if heard == 0 => Err(Error::NotFound {
                    name: name.to_owned(),
                    whereabouts: format!("at {}", endpoints.join(", ")),
                }),
                _ => Ok(()),
            }
        }
    }
}

/// Works on all places concurrently, and calls `tell` with each outcome as it arrives.
fn run_each<T: Send>(
    places: impl IntoIterator<Item = T>,
    work: impl Fn(T, &Sender<BroadcastOutcome>) + Sync,
    tell: &mut dyn FnMut(BroadcastOutcome),
) {
    let (told, heard) = channel();
    thread::scope(|scope| {
        for place in places {
            let (work, told) = (&work, told.clone());
            scope.spawn(move || work(place, &told));
        }
        drop(told);
        heard.iter().for_each(tell);
    });
}

/// Sends the order in each folder as soon as it is listed. A folder that cannot be listed is reported like an
/// application, since it may contain some.
fn send_local(
    folders: &Folders,
    name: Option<&str>,
    order: &[u8],
    tell: &mut dyn FnMut(BroadcastOutcome),
) -> Result<(), Error> {
    let (wanted, id) = choice::parts(name.unwrap_or_default());
    let meant = |entry: &Entry| entry.about.executor != REPLAY && choice::is_match(&entry.about, wanted, id);
    // All running applications, selected or not.
    let abouts: Mutex<Vec<About>> = Mutex::default();
    let first = |entry: &Entry| {
        let mut abouts = abouts.lock().unwrap_or_else(PoisonError::into_inner);
        // The same folder may be found under two names.
        let known = abouts.iter().any(|about| about.id == entry.about.id);
        if !known {
            abouts.push(entry.about.clone());
        }
        !known
    };
    let one = |entry: Entry, told: &Sender<BroadcastOutcome>| {
        let heard = BroadcastOutcome {
            outcome: send_to(&entry, order),
            target: entry.about.name,
        };
        // The receiver lives until all senders are dropped.
        let _ = told.send(heard);
    };
    let folder = |listing: Listing, told: &Sender<BroadcastOutcome>| {
        let who = listing.path().display().to_string();
        match listing.wait() {
            Ok(entries) => {
                let entries = entries.into_iter().filter(|entry| first(entry) && meant(entry));
                run_each(entries, one, &mut |heard| drop(told.send(heard)));
            }
            Err(error) => {
                let outcome = Err(error);
                drop(told.send(BroadcastOutcome { target: who, outcome }));
            }
        }
    };
    let mut anybody = false;
    run_each(folders.listings(), folder, &mut |heard| {
        anybody = true;
        tell(heard);
    });
    if anybody {
        return Ok(());
    }
    // Names the running applications if another was requested.
    let mut abouts = abouts.into_inner().unwrap_or_else(PoisonError::into_inner);
    abouts.sort_by_key(|about| about.started_ns);
    choice::choose(&abouts.iter().collect::<Vec<_>>(), name, super::ON_THIS_MACHINE)?;
    Err(Error::OnlyRecordings)
}

fn send_to(entry: &Entry, order: &[u8]) -> Result<Vec<String>, Error> {
    check_version(&entry.about)?;
    let connection = Connection::local(entry)?;
    let key = keys(&entry.about).of(OPERATE);
    let start = Instant::now();
    loop {
        match connection.query_one(&key, Some(order.to_vec()), REPLY_TIMEOUT)? {
            QueryOutcome::Reply(answer) => return roots(&entry.about.name, &answer.message),
            QueryOutcome::Refused(refusal) => {
                return Err(Error::Refused {
                    text: refusal.error,
                    nearest: refusal.nearest,
                });
            }
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
    order: &[u8],
    told: &Sender<BroadcastOutcome>,
) {
    let tell = |who: &str, outcome| {
        let who = who.to_owned();
        // The receiver lives until all senders are dropped.
        let _ = told.send(BroadcastOutcome { target: who, outcome });
    };
    if let Err(error) = send_to_endpoint(endpoint, (login, tls), name, order, &tell) {
        tell(endpoint, Err(error));
    }
}

/// Receives the name of the application and its outcome.
type Report<'a> = dyn Fn(&str, Result<Vec<String>, Error>) + 'a;

/// Sends the order to all applications behind an endpoint.
fn send_to_endpoint(
    endpoint: &String,
    (login, tls): (Option<&Login>, Option<&Tls>),
    name: Option<&str>,
    order: &[u8],
    tell: &Report,
) -> Result<(), Error> {
    let connection = Connection::network(endpoint, login, tls)?;
    let (wanted, id) = choice::parts(name.unwrap_or_default());
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
    let key = format!("jde/{PROTOCOL}/{}/{id}/{OPERATE}", any(wanted));
    let start = Instant::now();
    let mut heard: Vec<String> = Vec::new();
    while heard.is_empty() {
        let ended = connection.query(&key, Some(order.to_vec()), REPLY_TIMEOUT, |key, answer| {
            if heard.iter().any(|known| known == key) {
                return;
            }
            heard.push(key.to_owned());
            match answer {
                Ok(answer) => {
                    let who = key.split('/').nth(2).unwrap_or(endpoint);
                    tell(who, roots(who, &answer));
                }
                Err(refusal) => tell(
                    endpoint,
                    Err(Error::Refused {
                        text: refusal.error,
                        nearest: refusal.nearest,
                    }),
                ),
            }
        })?;
        if heard.is_empty() {
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
            // One application answered; another may not have.
            return Err(Error::Timeout {
                application: endpoint.clone(),
                waited: start.elapsed(),
            });
        }
    }
    Ok(())
}

fn roots(who: &str, answer: &[u8]) -> Result<Vec<String>, Error> {
    let garbled = |reason: String| Error::Garbled {
        application: who.to_owned(),
        reason,
    };
    let fine: OperateReply = serde_json::from_slice(answer).map_err(|error| garbled(error.to_string()))?;
    if fine.ok {
        Ok(fine.roots)
    } else {
        Err(garbled("it does not say that it did it".to_owned()))
    }
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
    use crate::message::Action;
    use crate::session::{SessionOptions, open};

    /// Two folders of the user, the second with an application called `robot` that confirms every order.
    struct Two {
        first: PathBuf,
        folders: Folders,
        _announced: Announcement,
        _robot: zenoh::Session,
        _files: tempfile::TempDir,
    }

    impl Two {
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
        fn stopped(&self) -> Vec<(String, Result<Vec<String>, String>)> {
            let stop = Request {
                by: "ana".to_owned(),
                action: Action::StopAll,
                lease_ms: None,
            };
            let mut heard = Vec::new();
            broadcast(&Reach::Local(self.folders.clone()), None, &stop, &mut |what| {
                heard.push((what.target, what.outcome.map_err(|error| error.to_string())));
            })
            .unwrap();
            heard
        }
    }

    fn robot() -> (String, Result<Vec<String>, String>) {
        ("robot".to_owned(), Ok(vec!["goon".to_owned()]))
    }

    #[test]
    fn r14_a_folder_that_does_not_answer_delays_nobody_and_is_named() {
        let _watchdog = Watchdog::for_test();
        let two = Two::new();
        // Opening a fifo to read waits for a writer, as a network file system may block.
        let hung = two.first.join("hung.json");
        mknodat(CWD, &hung, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        let heard = two.stopped();
        assert_eq!(heard[0], robot());
        let (who, error) = &heard[1];
        assert_eq!(*who, two.first.display().to_string());
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
    fn r14_a_folder_of_ones_own_that_cannot_be_listed_is_named_and_one_of_others_is_not() {
        let _watchdog = Watchdog::for_test();
        let two = Two::new();
        fs::set_permissions(&two.first, Permissions::from_mode(0o755)).unwrap();
        let mut heard = two.stopped();
        heard.sort_by_key(|(who, _)| who == "robot");
        assert_eq!(heard[1], robot());
        assert_eq!(heard[0].0, two.first.display().to_string());
        assert!(
            heard[0].1.as_ref().unwrap_err().contains("chmod 700"),
            "{heard:?}"
        );
        fs::remove_dir(&two.first).unwrap();
        fs::write(&two.first, "").unwrap();
        assert_eq!(two.stopped(), [robot()]);
    }
}
