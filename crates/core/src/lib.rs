//! The rules of action selection, as a pure state machine.
