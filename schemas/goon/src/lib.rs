//! Drives straight to the target while the way is free.
