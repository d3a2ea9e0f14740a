//! The two secrets of a page: whoever shows one has its right on that socket, and nowhere else.

use std::fs::File;
use std::io::{self, Read as _};

use crate::settings::Right;

/// The characters of a token: 32, so that a byte gives one without a bias, and none that is taken for another.
const ALPHABET: &[u8; 32] = b"abcdefghijkmnpqrstuvwxyz23456789";
/// Characters of a token: 120 bits.
const LENGTH: usize = 24;

/// The tokens of a page, new for each run.
pub(crate) struct Tokens {
    read: String,
    /// None if nobody may operate.
    operate: Option<String>,
}

impl Tokens {
    /// Creates tokens for visitors that may do this at most.
    ///
    /// # Errors
    /// The system gives no randomness.
    pub(crate) fn new(access: Right) -> io::Result<Self> {
        Ok(Self {
            read: random()?,
            operate: (access == Right::Operate).then(random).transpose()?,
        })
    }

    /// Returns the token of a right, if anybody may have it.
    pub(crate) fn of(&self, right: Right) -> Option<&str> {
        match right {
            Right::Read => Some(&self.read),
            Right::Operate => self.operate.as_deref(),
        }
    }

    /// Returns the right that a token gives.
    pub(crate) fn right(&self, shown: &str) -> Option<Right> {
        let operate = self.operate.as_deref().is_some_and(|token| is_same(token, shown));
        let read = is_same(&self.read, shown);
        match (operate, read) {
            (true, _) => Some(Right::Operate),
            (false, true) => Some(Right::Read),
            (false, false) => None,
        }
    }
}

/// Compares in a time that does not depend on where the texts differ.
fn is_same(token: &str, shown: &str) -> bool {
    let pairs = token.bytes().zip(shown.bytes());
    let differences = pairs.fold(0, |all, (one, other)| all | (one ^ other));
    token.len() == shown.len() && std::hint::black_box(differences) == 0
}

fn random() -> io::Result<String> {
    let mut bytes = [0; LENGTH];
    File::open("/dev/urandom")?.read_exact(&mut bytes)?;
    let letter = |byte: &u8| char::from(ALPHABET[usize::from(byte % 32)]);
    Ok(bytes.iter().map(letter).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_token_gives_its_right_and_nothing_else_gives_one() {
        let tokens = Tokens::new(Right::Operate).unwrap();
        let read = tokens.of(Right::Read).unwrap();
        let operate = tokens.of(Right::Operate).unwrap();
        assert_eq!((read.len(), operate.len()), (LENGTH, LENGTH));
        assert_eq!(tokens.right(read), Some(Right::Read));
        assert_eq!(tokens.right(operate), Some(Right::Operate));
        for wrong in ["", "a", &read[1..], &format!("{read}a"), &operate.to_uppercase()] {
            assert_eq!(tokens.right(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn a_page_to_look_at_has_no_token_to_operate() {
        let tokens = Tokens::new(Right::Read).unwrap();
        assert_eq!(tokens.of(Right::Operate), None);
        assert_eq!(tokens.right(""), None);
    }

    #[test]
    fn no_run_has_the_tokens_of_another() {
        let token = || Tokens::new(Right::Read).unwrap().read;
        assert_ne!(token(), token());
    }
}
