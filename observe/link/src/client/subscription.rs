//! Subscriptions, and the liveliness tokens by which an application learns of them. Free token names are
//! reused, because both ends keep each name ever declared in memory while they are connected.

use std::collections::HashSet;
use std::sync::Arc;

use parking_lot::Mutex;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Subscriber;
use zenoh::{Session, Wait};

use super::Remote;
use crate::Error;

/// A subscription; dropping it ends it.
pub struct Subscription {
    _subscribers: Vec<Subscriber<()>>,
    _token: Option<Token>,
    _remote: Remote,
}

impl Subscription {
    pub(super) fn new(subscribers: Vec<Subscriber<()>>, token: Option<Token>, remote: &Remote) -> Self {
        Self {
            _subscribers: subscribers,
            _token: token,
            _remote: remote.clone(),
        }
    }
}

/// Requests a publication until dropped.
pub(super) struct Token {
    // Undeclared before its name is free.
    _declared: LivelinessToken,
    _name: ReservedName,
}

/// The tokens of one client.
pub(super) struct Tokens {
    /// Distinguishes this client's tokens from those of others.
    client: String,
    in_use: Arc<NamesInUse>,
}

/// The names in use.
type NamesInUse = Mutex<HashSet<String>>;

/// A name in use; free when dropped.
struct ReservedName {
    key: String,
    in_use: Arc<NamesInUse>,
}

impl Tokens {
    pub(super) fn new(client: String) -> Self {
        Self {
            client,
            in_use: Arc::default(),
        }
    }

    /// Declares a token; `key` makes its name from the client's.
    ///
    /// # Errors
    /// [`Error::Open`].
    pub(super) fn declare(&self, session: &Session, key: impl Fn(&str) -> String) -> Result<Token, Error> {
        let name = self.reserve(key);
        let declared = session.liveliness().declare_token(&name.key).wait();
        Ok(Token {
            _declared: declared.map_err(|error| Error::Open(error.to_string()))?,
            _name: name,
        })
    }

    /// Takes the first free name: several subscriptions may request the same publication.
    fn reserve(&self, key: impl Fn(&str) -> String) -> ReservedName {
        let mut taken = self.in_use.lock();
        let mut number = 0_u64;
        loop {
            let key = key(&format!("{}-{number}", self.client));
            if taken.insert(key.clone()) {
                return ReservedName {
                    key,
                    in_use: Arc::clone(&self.in_use),
                };
            }
            number += 1;
        }
    }
}

impl Drop for ReservedName {
    fn drop(&mut self) {
        self.in_use.lock().remove(&self.key);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_free_name_is_reused_and_one_in_use_is_not() {
        let tokens = Tokens::new("c1".to_owned());
        let reserve_laser = || tokens.reserve(|client| format!("want/laser/{client}"));
        let (first, second) = (reserve_laser(), reserve_laser());
        assert_eq!(
            [&*first.key, &*second.key],
            ["want/laser/c1-0", "want/laser/c1-1"]
        );
        assert_eq!(
            tokens.reserve(|client| format!("want/pose/{client}")).key,
            "want/pose/c1-0"
        );
        drop(first);
        for _ in 0..1000 {
            assert_eq!(reserve_laser().key, "want/laser/c1-0");
        }
        drop(second);
        assert!(tokens.in_use.lock().is_empty());
    }
}
