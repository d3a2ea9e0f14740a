//! The tree of frames that other nodes publish: each frame has one parent, and a history of where it is in it. A
//! transform that the tree does not have for certain is an error in words.

use core::fmt;
use std::collections::BTreeMap;
use std::collections::VecDeque;
use std::collections::btree_map::Entry;

use jde_schema::types::Transform;

use super::history::{Beyond, History, KEPT_NS, normalized};

/// Most frames.
const MAX_FRAMES: usize = 1024;
/// Most bytes of a frame's name, which is kept and may be logged.
const MAX_NAME: usize = 255;
/// Greatest error of the length of a rotation's quaternion: that of tf2.
const TOLERANCE: f64 = 0.01;
/// Most frames that a message lists.
const MAX_LISTED: usize = 12;

/// The frames, by their names without a leading slash.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    edges: BTreeMap<String, Edge>,
    /// The newest time of a transform that changes, ns.
    newest: i64,
}

/// A frame in its parent.
#[derive(Clone, Debug)]
struct Edge {
    parent: String,
    history: History,
    rival: Option<Rival>,
}

/// What contradicts a frame: another parent, or a transform that is static where the frame moves or the reverse.
#[derive(Clone, Debug)]
struct Rival {
    parent: String,
    /// The time of its newest transform, ns; `None` if it is static, and counts at all times.
    stamp: Option<i64>,
}

/// A frame in another one, as somebody publishes it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Published<'a> {
    pub(crate) parent: &'a str,
    pub(crate) child: &'a str,
    /// Time, ns; not used if it is static.
    pub(crate) stamp: i64,
    pub(crate) transform: Transform,
    pub(crate) is_static: bool,
}

/// A transform and its time, ns; `None` if it is valid at all times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Found {
    pub(crate) stamp: Option<i64>,
    pub(crate) transform: Transform,
}

/// Why there is no transform.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum LookupError {
    /// Nobody publishes a frame; these are known.
    Unknown { frame: String, known: String },
    /// No frames lead from one to the other; each belongs to the tree of a root.
    Apart { frames: [String; 2], roots: [String; 2] },
    /// A frame has two parents.
    TwoParents { child: String, parents: [String; 2] },
    /// A frame is static in its parent, and moves in it.
    StaticAndMoves { child: String, parent: String },
    /// A frame in its parent is silent for so many seconds, and the others have no transform of before.
    Silent {
        child: String,
        parent: String,
        seconds: f64,
    },
    /// A frame in its parent is known until so many seconds before the time that was asked for.
    TooNew {
        child: String,
        parent: String,
        seconds: f64,
    },
    /// A frame in its parent is known only from so many seconds after the time that was asked for.
    TooOld {
        child: String,
        parent: String,
        seconds: f64,
    },
}

impl fmt::Display for LookupError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { frame, known } => {
                write!(f, "nobody publishes the frame `{frame}`; known are {known}")
            }
            Self::Apart {
                frames: [target, source],
                roots: [first, second],
            } => write!(
                f,
                "nothing connects `{target}` and `{source}`: they are in the trees of `{first}` and `{second}`"
            ),
            Self::TwoParents {
                child,
                parents: [first, second],
            } => write!(
                f,
                "`{child}` has two parents, `{first}` and `{second}`: stop one of the nodes that publish it"
            ),
            Self::StaticAndMoves { child, parent } => write!(
                f,
                "`{child}` in `{parent}` is static and moves: stop one of the nodes that publish it"
            ),
            Self::Silent {
                child,
                parent,
                seconds,
            } => write!(f, "`{child}` in `{parent}` has been silent for {seconds:.1} s"),
            Self::TooNew {
                child,
                parent,
                seconds,
            } => write!(
                f,
                "`{child}` in `{parent}` ends {seconds:.3} s before the time that is asked for"
            ),
            Self::TooOld {
                child,
                parent,
                seconds,
            } => write!(
                f,
                "`{child}` in `{parent}` begins {seconds:.3} s after the time that is asked for"
            ),
        }
    }
}

impl Tree {
    /// Forgets all but the static transforms: time has jumped back.
    pub(crate) fn forget_moving(&mut self) {
        self.edges
            .retain(|_, edge| matches!(edge.history, History::Fixed(_)));
        self.edges.values_mut().for_each(|edge| edge.rival = None);
        self.newest = 0;
    }

    /// Adds a transform.
    ///
    /// # Errors
    /// If it contradicts what is known, or has invalid numbers. Then the tree is as before, but for a frame with two
    /// parents or one that is static and moves, which no lookup passes.
    pub(crate) fn insert(&mut self, published: &Published<'_>) -> Result<(), String> {
        let Published { stamp, is_static, .. } = *published;
        let (parent, child) = (plain(published.parent), plain(published.child));
        if parent.is_empty() || child.is_empty() {
            return Err("a transform without the name of a frame".to_owned());
        }
        if let Some(long) = [parent, child].into_iter().find(|name| name.len() > MAX_NAME) {
            let begin = &long[..long.floor_char_boundary(40)];
            return Err(format!(
                "the name of a frame has more than {MAX_NAME} bytes: `{begin}`..."
            ));
        }
        let transform = valid(&published.transform)
            .ok_or_else(|| format!("`{child}` in `{parent}` has invalid numbers"))?;
        let loops = parent == child || self.ancestors(parent).any(|ancestor| ancestor == child);
        let is_full = self.edges.len() >= MAX_FRAMES;
        if !is_static {
            self.newest = self.newest.max(stamp);
        }
        let stamp_of_rival = (!is_static).then_some(stamp);
        match self.edges.entry(child.to_owned()) {
            _ if loops => Err(format!("`{child}` in `{parent}` would close a loop of frames")),
            Entry::Vacant(_) if is_full => {
                Err(format!("more than {MAX_FRAMES} frames; `{child}` is ignored"))
            }
            Entry::Vacant(place) => {
                place.insert(Edge::new(parent, stamp, transform, is_static));
                Ok(())
            }
            Entry::Occupied(mut place) if place.get().parent != parent => {
                let edge = place.get_mut();
                let is_silent = |newest| newest < stamp.saturating_sub(KEPT_NS);
                if !is_static && edge.history.newest().is_some_and(is_silent) {
                    *edge = Edge::new(parent, stamp, transform, is_static);
                    return Ok(());
                }
                Err(edge.contradict(child, parent, stamp_of_rival))
            }
            Entry::Occupied(mut place) => {
                let edge = place.get_mut();
                if is_static != matches!(edge.history, History::Fixed(_)) {
                    return Err(edge.contradict(child, parent, stamp_of_rival));
                }
                if edge.history.insert(stamp, transform) {
                    return Ok(());
                }
                Err(format!("`{child}` in `{parent}` comes more than 10 s late"))
            }
        }
    }

    /// Returns where `source` is in `target` at a time, ns; without one, at the newest time at which all frames between them are known.
    ///
    /// # Errors
    /// If that is not known.
    pub(crate) fn lookup(
        &self,
        target: &str,
        source: &str,
        stamp: Option<i64>,
    ) -> Result<Found, LookupError> {
        let (target, source) = (plain(target), plain(source));
        for frame in [target, source] {
            if !self.knows(frame) {
                return Err(self.unknown(frame));
            }
        }
        let (up, down) = (self.path(target), self.path(source));
        let (Some(first), Some(second)) = (up.last(), down.last()) else {
            return Err(self.unknown(target));
        };
        if first != second {
            return Err(LookupError::Apart {
                frames: [target.to_owned(), source.to_owned()],
                roots: [(*first).to_owned(), (*second).to_owned()],
            });
        }
        // The common frames at the end of both paths; both leave the last of them out.
        let common = up.iter().rev().zip(down.iter().rev());
        let common = common.take_while(|(a, b)| a == b).count();
        let (up, down) = (&up[..up.len() - common], &down[..down.len() - common]);
        let children = up.iter().chain(down).copied();
        let oldest = children
            .filter_map(|child| Some((self.edges[child].history.newest()?, child)))
            .min();
        let stamp_of_all = match (oldest, stamp) {
            (None, _) => None,
            (Some((newest, _)), None) => Some(newest),
            (_, stamp) => stamp,
        };
        let composed = self
            .compose(up, stamp_of_all)
            .and_then(|up| Ok(up.inverse().compose(&self.compose(down, stamp_of_all)?)));
        match (composed, oldest) {
            (Err(LookupError::TooOld { .. }), Some((newest, child))) if stamp.is_none() => {
                Err(LookupError::Silent {
                    child: child.to_owned(),
                    parent: self.edges[child].parent.clone(),
                    seconds: seconds(newest, self.newest),
                })
            }
            (composed, _) => composed.map(|transform| Found {
                stamp: stamp_of_all,
                transform,
            }),
        }
    }

    /// Returns the transform of the first of these frames in the parent of the last.
    fn compose(&self, frames: &[&str], stamp: Option<i64>) -> Result<Transform, LookupError> {
        let mut composed = Transform::IDENTITY;
        for child in frames {
            let edge = &self.edges[*child];
            if let Some(rival) = edge.rival.as_ref().filter(|rival| rival.counts(self.newest)) {
                return Err(edge.contradiction(child, rival));
            }
            // Without a time all of them are static.
            let stamp = stamp.unwrap_or(0);
            let next = edge.history.at(stamp);
            composed = next
                .map_err(|beyond| edge.beyond(child, stamp, beyond))?
                .compose(&composed);
        }
        Ok(composed)
    }

    fn knows(&self, frame: &str) -> bool {
        self.edges.contains_key(frame) || self.edges.values().any(|edge| edge.parent == frame)
    }

    /// A frame and all above it, to the root.
    fn path<'a>(&'a self, frame: &'a str) -> Vec<&'a str> {
        core::iter::once(frame).chain(self.ancestors(frame)).collect()
    }

    /// All frames above a frame, up to the root. No loop of frames was ever inserted.
    fn ancestors<'a>(&'a self, frame: &'a str) -> impl Iterator<Item = &'a str> {
        let parent = |frame: &&'a str| self.edges.get(*frame).map(|edge| edge.parent.as_str());
        core::iter::successors(parent(&frame), parent)
    }

    fn unknown(&self, frame: &str) -> LookupError {
        let parents = self.edges.values().map(|edge| edge.parent.as_str());
        let mut known: Vec<&str> = self.edges.keys().map(String::as_str).chain(parents).collect();
        known.sort_unstable();
        known.dedup();
        let more = known.len().saturating_sub(MAX_LISTED);
        known.truncate(MAX_LISTED);
        let mut known = known.join(", ");
        match (known.is_empty(), more) {
            (true, _) => known.push_str("none"),
            (false, 0) => {}
            (false, more) => known.push_str(&format!(" and {more} more")),
        }
        LookupError::Unknown {
            frame: frame.to_owned(),
            known,
        }
    }
}

impl Edge {
    fn new(parent: &str, stamp: i64, transform: Transform, is_static: bool) -> Self {
        Self {
            parent: parent.to_owned(),
            history: if is_static {
                History::Fixed(transform)
            } else {
                History::Moving(VecDeque::from([(stamp, transform)]))
            },
            rival: None,
        }
    }

    /// Adds what contradicts it, and returns that in words. What is static counts for longer.
    fn contradict(&mut self, child: &str, parent: &str, stamp: Option<i64>) -> String {
        let rival = Rival {
            parent: parent.to_owned(),
            stamp,
        };
        let error = self.contradiction(child, &rival).to_string();
        if self.rival.as_ref().is_none_or(|rival| rival.stamp.is_some()) {
            self.rival = Some(rival);
        }
        error
    }

    fn contradiction(&self, child: &str, rival: &Rival) -> LookupError {
        let (child, parent) = (child.to_owned(), self.parent.clone());
        match rival.parent == parent {
            true => LookupError::StaticAndMoves { child, parent },
            false => LookupError::TwoParents {
                child,
                parents: [parent, rival.parent.clone()],
            },
        }
    }

    fn beyond(&self, child: &str, stamp: i64, beyond: Beyond) -> LookupError {
        let (child, parent) = (child.to_owned(), self.parent.clone());
        match beyond {
            Beyond::Newest(newest) => LookupError::TooNew {
                child,
                parent,
                seconds: seconds(newest, stamp),
            },
            Beyond::Oldest(oldest) => LookupError::TooOld {
                child,
                parent,
                seconds: seconds(stamp, oldest),
            },
        }
    }
}

impl Rival {
    /// Whether it is as new as the transforms that are kept.
    fn counts(&self, newest: i64) -> bool {
        self.stamp
            .is_none_or(|stamp| stamp >= newest.saturating_sub(KEPT_NS))
    }
}

/// The time between two stamps in ns.
fn seconds(from: i64, to: i64) -> f64 {
    (i128::from(to) - i128::from(from)) as f64 / 1e9
}

/// A frame's name without the leading slash that ROS 1 allowed.
fn plain(frame: &str) -> &str {
    frame.strip_prefix('/').unwrap_or(frame)
}

/// The transform with a rotation of length 1; `None` if its numbers are invalid.
fn valid(transform: &Transform) -> Option<Transform> {
    let Transform {
        translation,
        rotation,
    } = *transform;
    let squares = [rotation.x, rotation.y, rotation.z, rotation.w].map(|part| part * part);
    let is_finite = [translation.x, translation.y, translation.z]
        .iter()
        .all(|part| part.is_finite());
    let is_unit = (squares.iter().sum::<f64>() - 1.0).abs() <= TOLERANCE;
    (is_finite && is_unit).then(|| Transform {
        translation,
        rotation: normalized(rotation),
    })
}
