//! `jde record`: records an application that runs elsewhere.
