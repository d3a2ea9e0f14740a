//! The variables that a window requested lately, and the values for readers that need all of them.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

use eframe::egui;
use jde_link::{Rate, Remote, Sample};

use super::backlog::Backlog;
use super::demand::LastRequest;
use super::watch_list::WatchList;

pub(super) struct Subscriptions {
    list: WatchList<Values>,
    /// The readers of each variable that need all values.
    readers: HashMap<String, Readers>,
}

/// What arrived of a variable.
#[derive(Default)]
struct Values {
    newest: Option<Arc<Sample>>,
    /// Values since a reader last called, while there are readers.
    fresh: Option<Backlog>,
}

/// The readers of one variable. Each has the values since its last call, and the time of that call.
#[derive(Default)]
struct Readers(HashMap<String, (Backlog, LastRequest)>);

impl Subscriptions {
    pub(super) fn new(remote: Remote, repaint: egui::Context) -> Self {
        Self {
            list: WatchList::new("view-subscribe", repaint, move |name, rate, sink| {
                remote.watch(name, rate, move |sample| {
                    sink.update(|values: &mut Values| values.push(Arc::new(sample)));
                })
            }),
            readers: HashMap::new(),
        }
    }

    pub(super) fn newest(&mut self, name: &str, rate: Rate) -> Option<Arc<Sample>> {
        self.list.request(name, rate).received.newest.clone()
    }

    pub(super) fn since(&mut self, name: &str, rate: Rate, reader: &str) -> Vec<Arc<Sample>> {
        let values = &mut self.list.request(name, rate).received;
        let readers = self.readers.entry(name.to_owned()).or_default();
        readers.since(values, reader, Instant::now())
    }

    pub(super) fn trouble(&self, name: &str) -> Option<String> {
        self.list.get(name)?.failure()
    }

    /// Ends what is no longer used, see [`WatchList::remove_unused`].
    pub(super) fn remove_unused(&mut self) {
        self.list.remove_unused();
        let now = Instant::now();
        self.readers.retain(|name, readers| match self.list.get(name) {
            Some(mut slot) => readers.remove_idle(&mut slot.received, now),
            None => false,
        });
    }
}

impl Values {
    fn push(&mut self, sample: Arc<Sample>) {
        if let Some(fresh) = &mut self.fresh {
            fresh.push(Arc::clone(&sample));
        }
        self.newest = Some(sample);
    }
}

impl Readers {
    /// The values since this reader's last call. The first call registers the reader.
    fn since(&mut self, values: &mut Values, reader: &str, now: Instant) -> Vec<Arc<Sample>> {
        if !self.0.contains_key(reader) {
            self.0
                .insert(reader.to_owned(), (Backlog::default(), LastRequest::new(now)));
        }
        for sample in values.fresh.get_or_insert_with(Backlog::default).take() {
            for (backlog, _) in self.0.values_mut() {
                backlog.push(Arc::clone(&sample));
            }
        }
        self.0
            .get_mut(reader)
            .map(|(backlog, request)| {
                *request = LastRequest::new(now);
                backlog.take()
            })
            .unwrap_or_default()
    }

    /// Removes readers that stopped calling. Returns whether any remains.
    fn remove_idle(&mut self, values: &mut Values, now: Instant) -> bool {
        self.0.retain(|_, (_, request)| request.check(now));
        if self.0.is_empty() {
            values.fresh = None;
        }
        !self.0.is_empty()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use jde_types::Value as _;

    use super::super::demand::PATIENCE;
    use super::*;

    pub(in super::super) fn sample(sequence: u64, bytes: usize) -> Arc<Sample> {
        Arc::new(Sample {
            value_type: Arc::new(f64::describe()),
            bytes: Some(vec![0; bytes].into()),
            sequence,
            time: sequence,
            age: 0,
            valid_until: u64::MAX,
            writer: String::new(),
        })
    }

    #[test]
    fn a_reader_receives_every_value_once_and_an_idle_reader_is_removed() {
        let start = Instant::now();
        let (mut values, mut readers) = (Values::default(), Readers::default());
        let numbers = |samples: Vec<Arc<Sample>>| -> Vec<u64> {
            samples.iter().map(|sample| sample.sequence).collect()
        };
        values.push(sample(1, 8));
        assert!(values.fresh.is_none(), "without a reader, no values are kept");
        assert!(numbers(readers.since(&mut values, "first", start)).is_empty());
        readers.since(&mut values, "second", start);
        (2..4).for_each(|number| values.push(sample(number, 8)));
        assert_eq!(numbers(readers.since(&mut values, "first", start)), [2, 3]);
        assert!(numbers(readers.since(&mut values, "first", start)).is_empty());
        assert_eq!(numbers(readers.since(&mut values, "second", start)), [2, 3]);

        let later = start + PATIENCE / 2;
        assert!(readers.remove_idle(&mut values, later));
        readers.since(&mut values, "first", later);
        values.push(sample(4, 8));
        assert!(readers.remove_idle(&mut values, start + PATIENCE));
        assert_eq!(readers.0.keys().collect::<Vec<_>>(), ["first"]);
        assert_eq!(
            numbers(readers.since(&mut values, "first", later)),
            [4],
            "the remaining reader misses none"
        );
        readers.remove_idle(&mut values, later + PATIENCE);
        assert!(!readers.remove_idle(&mut values, later + PATIENCE));
        values.push(sample(5, 8));
        assert!(values.fresh.is_none());
    }
}
