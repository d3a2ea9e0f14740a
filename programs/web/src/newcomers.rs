//! The places of connections that have not shown a token. Where all are taken, the address with the most loses its oldest one
//! to another address with fewer: one address alone keeps nobody out, and a class behind one address has all of them.

use std::collections::VecDeque;
use std::net::IpAddr;
use std::sync::Arc;

use parking_lot::Mutex;
use tokio::sync::oneshot;

/// The places.
pub(crate) struct Newcomers {
    most: usize,
    /// Oldest first.
    taken: Mutex<VecDeque<Taken>>,
}

struct Taken {
    number: u64,
    from: IpAddr,
    /// Dropped to take the place away.
    _hold: oneshot::Sender<()>,
}

/// The place of a connection, free when dropped.
pub(crate) struct Place {
    newcomers: Arc<Newcomers>,
    number: u64,
    lost: oneshot::Receiver<()>,
}

impl Newcomers {
    /// Creates places for at most so many connections.
    pub(crate) fn new(most: usize) -> Arc<Self> {
        let taken = Mutex::default();
        Arc::new(Self { most, taken })
    }

    /// Returns a place for the connection of this number; `None` if all are taken by addresses that have no more of them.
    pub(crate) fn admit(self: &Arc<Self>, number: u64, from: IpAddr) -> Option<Place> {
        let from = owner(from);
        let mut taken = self.taken.lock();
        if taken.len() >= self.most {
            let of = |address| taken.iter().filter(|one| one.from == address).count();
            let greatest = taken
                .iter()
                .map(|one| one.from)
                .max_by_key(|address| of(*address))?;
            if of(greatest) <= of(from) + 1 {
                return None;
            }
            let oldest = taken.iter().position(|one| one.from == greatest)?;
            taken.remove(oldest);
        }
        let (hold, lost) = oneshot::channel();
        taken.push_back(Taken {
            number,
            from,
            _hold: hold,
        });
        let newcomers = Arc::clone(self);
        Some(Place {
            newcomers,
            number,
            lost,
        })
    }
}

/// Who has an address: of IPv6 a machine has as many as it likes below its network.
fn owner(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(six) => IpAddr::V6((six.to_bits() & !u128::from(u64::MAX)).into()),
        four @ IpAddr::V4(_) => four,
    }
}

impl Place {
    /// Waits for what a connection does without a token; `None` if it has lost its place meanwhile.
    pub(crate) async fn during<T>(&mut self, work: impl Future<Output = T>) -> Option<T> {
        tokio::select! {
            _ = &mut self.lost => None,
            done = work => Some(done),
        }
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.newcomers
            .taken
            .lock()
            .retain(|one| one.number != self.number);
    }
}

#[cfg(test)]
mod tests {
    use std::future::ready;

    use super::*;

    fn has_place(place: &mut Place) -> bool {
        place.lost.try_recv() == Err(oneshot::error::TryRecvError::Empty)
    }

    #[test]
    fn one_address_does_not_keep_another_one_out() {
        let newcomers = Newcomers::new(8);
        let address = |text: &str| text.parse::<IpAddr>().unwrap();
        let (flood, other) = (address("10.0.0.66"), address("10.0.0.7"));
        let mut flooding: Vec<_> = (0..8)
            .filter_map(|number| newcomers.admit(number, flood))
            .collect();
        assert_eq!(flooding.len(), 8, "alone it has all");
        assert!(newcomers.admit(8, flood).is_none());
        let late: Vec<_> = (10..20)
            .filter_map(|number| newcomers.admit(number, other))
            .collect();
        assert_eq!(late.len(), 4, "each has its half");
        let kept: Vec<_> = flooding.iter_mut().map(has_place).collect();
        assert_eq!(kept, [false, false, false, false, true, true, true, true]);
        drop(flooding);
        assert!(newcomers.admit(30, flood).is_some(), "places become free");
    }

    #[test]
    fn a_network_of_ipv6_is_one_address() {
        let address = |text: &str| owner(text.parse().unwrap());
        assert_eq!(address("2001:db8:1:2::3"), address("2001:db8:1:2:ffff::4"));
        assert_ne!(address("2001:db8:1:2::3"), address("2001:db8:1:3::3"));
        assert_eq!(address("::ffff:10.0.0.7"), address("10.0.0.7"));
    }

    #[tokio::test]
    async fn what_loses_its_place_ends() {
        let newcomers = Newcomers::new(2);
        let (one, other) = ("10.0.0.1".parse().unwrap(), "10.0.0.2".parse().unwrap());
        let mut first = newcomers.admit(1, one).unwrap();
        let _second = newcomers.admit(2, one).unwrap();
        assert_eq!(first.during(ready(7)).await, Some(7));
        let _third = newcomers.admit(3, other).unwrap();
        assert_eq!(first.during(std::future::pending::<()>()).await, None);
    }
}
