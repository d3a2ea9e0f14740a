//! The form in messages of a type that several ports or fields share.

use std::cell::Cell;
use std::sync::Arc;

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::Type;

/// More than the ABI lets types nest; a damaged process could send any depth.
const MAX_DEPTH: usize = 32;
thread_local! {
    /// The types around the one that is read.
    static DEPTH: Cell<usize> = const { Cell::new(0) };
}

pub(crate) fn serialize<S: Serializer>(ty: &Arc<Type>, to: S) -> Result<S::Ok, S::Error> {
    Type::serialize(ty, to)
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Arc<Type>, D::Error> {
    let depth = DEPTH.get();
    if depth == MAX_DEPTH {
        return Err(D::Error::custom("its type nests too deeply"));
    }
    DEPTH.set(depth + 1);
    let read = Type::deserialize(from);
    DEPTH.set(depth);
    read.map(Arc::new)
}
