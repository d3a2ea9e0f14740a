//! What is about everything, asked of everybody at once (R14). The order is the first thing that is said to each, and its own answer is
//! all that counts: nothing is asked before it, and nobody waits for anybody else.

use std::sync::mpsc::{Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use super::connection::{Answered, Connection};
use super::{ANSWER, Reach, check_version, choice, keys};
use crate::Error;
use crate::folder::{Entry, Folders};
use crate::keys::{OPERATE, PROTOCOL, chunk};
use crate::message::{Fine, Request};
use crate::session::{Login, Tls};

/// How long an order is said again that nobody took: an application may just be showing what it has, or have no room.
const UNHEARD: Duration = Duration::from_secs(2);
const AGAIN: Duration = Duration::from_millis(50);
/// What replays a recording calls itself so.
const REPLAY: &str = "replay";

/// What came of it at one application, or at an endpoint where none could be heard.
#[derive(Debug)]
pub struct Heard {
    /// The name of the application, or the endpoint.
    pub who: String,
    /// The roots that were meant.
    pub outcome: Result<Vec<String>, Error>,
}

/// Has all applications there do something about everything, or the one of that name, and has `tell` called with what came of it as
/// answers come. Whoever does not answer is told as well.
///
/// # Errors
/// [`Error::Folder`]; [`Error::NothingRuns`], [`Error::UnknownApplication`], [`Error::NotThere`] and [`Error::OnlyRecordings`] if nobody
/// was meant. Takes 11 s at most.
pub fn everything(
    reach: &Reach,
    name: Option<&str>,
    request: &Request,
    tell: &mut dyn FnMut(Heard),
) -> Result<(), Error> {
    let order = serde_json::to_vec(request).map_err(|error| Error::Open(error.to_string()))?;
    match reach {
        Reach::Local(folders) => here(folders, name, &order, tell),
        Reach::Network {
            endpoints,
            login,
            tls,
        } => {
            let there = |endpoint: &String, told: &Sender<Heard>| {
                there(endpoint, (login.as_ref(), tls.as_ref()), name, &order, told)
            };
            let mut heard = 0;
            each(endpoints, there, &mut |what| {
                heard += 1;
                tell(what);
            });
            match name {
                Some(name) if heard == 0 => Err(Error::NotThere {
                    name: name.to_owned(),
                    whereabouts: format!("at {}", endpoints.join(", ")),
                }),
                _ => Ok(()),
            }
        }
    }
}

/// Works at each place at the same time, and has what is heard told as it comes.
fn each<T: Sync>(places: &[T], work: impl Fn(&T, &Sender<Heard>) + Sync, tell: &mut dyn FnMut(Heard)) {
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

fn here(
    folders: &Folders,
    name: Option<&str>,
    order: &[u8],
    tell: &mut dyn FnMut(Heard),
) -> Result<(), Error> {
    let mut entries = folders.list()?;
    let (wanted, id) = choice::parts(name.unwrap_or_default());
    let meant = |entry: &Entry| entry.about.executor != REPLAY && choice::fits(&entry.about, wanted, id);
    if !entries.iter().any(meant) {
        // Says which there are, if another was meant.
        let abouts: Vec<_> = entries.iter().map(|entry| &entry.about).collect();
        let _recording = choice::choose(&abouts, name, super::HERE)?;
        return Err(Error::OnlyRecordings);
    }
    entries.retain(meant);
    let one = |entry: &Entry, told: &Sender<Heard>| {
        let heard = Heard {
            who: entry.about.name.clone(),
            outcome: at(entry, order),
        };
        // Whoever listens listens to the end.
        let _ = told.send(heard);
    };
    each(&entries, one, tell);
    Ok(())
}

fn at(entry: &Entry, order: &[u8]) -> Result<Vec<String>, Error> {
    check_version(&entry.about)?;
    let connection = Connection::local(entry)?;
    let key = keys(&entry.about).of(OPERATE);
    let start = Instant::now();
    loop {
        match connection.ask_one(&key, Some(order.to_vec()), ANSWER)? {
            Answered::With(answer) => return roots(&entry.about.name, &answer.message),
            Answered::Refused(refusal) => {
                return Err(Error::Refused {
                    text: refusal.error,
                    nearest: refusal.nearest,
                });
            }
            Answered::NotAtAll if start.elapsed() < UNHEARD => thread::sleep(AGAIN),
            Answered::NotAtAll | Answered::TooLate => {
                return Err(Error::NoAnswer {
                    application: entry.about.name.clone(),
                    waited: start.elapsed(),
                });
            }
        }
    }
}

fn there(
    endpoint: &String,
    (login, tls): (Option<&Login>, Option<&Tls>),
    name: Option<&str>,
    order: &[u8],
    told: &Sender<Heard>,
) {
    let tell = |who: &str, outcome| {
        let who = who.to_owned();
        // Whoever listens listens to the end.
        let _ = told.send(Heard { who, outcome });
    };
    if let Err(error) = say(endpoint, (login, tls), name, order, &tell) {
        tell(endpoint, Err(error));
    }
}

/// Takes who answered, and what.
type Tell<'a> = dyn Fn(&str, Result<Vec<String>, Error>) + 'a;

/// Says it to all whom an endpoint leads to.
fn say(
    endpoint: &String,
    (login, tls): (Option<&Login>, Option<&Tls>),
    name: Option<&str>,
    order: &[u8],
    tell: &Tell,
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
        let ended = connection.ask(&key, Some(order.to_vec()), ANSWER, |key, answer| {
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
                return Err(Error::NoAnswer {
                    application: endpoint.clone(),
                    waited: start.elapsed(),
                });
            }
            if start.elapsed() >= UNHEARD {
                return match name {
                    // It may be elsewhere.
                    Some(_) => Ok(()),
                    None => Err(Error::NothingRuns(format!("at {endpoint}"))),
                };
            }
            thread::sleep(AGAIN);
        } else if !ended {
            // Somebody answered, and somebody else may be there who has not.
            return Err(Error::NoAnswer {
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
    let fine: Fine = serde_json::from_slice(answer).map_err(|error| garbled(error.to_string()))?;
    if fine.ok {
        Ok(fine.roots)
    } else {
        Err(garbled("it does not say that it did it".to_owned()))
    }
}
