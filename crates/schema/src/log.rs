//! The log: five macros, `trace!(cx, "...")` to `error!(cx, "...")`, with texts as `format!` takes them.

/// Says something for the developer of this schema, in every iteration if need be.
#[macro_export]
macro_rules! trace {
    ($cx:expr, $($text:tt)+) => {
        $cx.log($crate::Severity::Trace, ::core::format_args!($($text)+))
    };
}

/// Says something for the developer of this schema.
#[macro_export]
macro_rules! debug {
    ($cx:expr, $($text:tt)+) => {
        $cx.log($crate::Severity::Debug, ::core::format_args!($($text)+))
    };
}

/// Says something for whoever runs the application.
#[macro_export]
macro_rules! info {
    ($cx:expr, $($text:tt)+) => {
        $cx.log($crate::Severity::Info, ::core::format_args!($($text)+))
    };
}

/// Says that something is off and the schema goes on.
#[macro_export]
macro_rules! warn {
    ($cx:expr, $($text:tt)+) => {
        $cx.log($crate::Severity::Warn, ::core::format_args!($($text)+))
    };
}

/// Says that something failed.
#[macro_export]
macro_rules! error {
    ($cx:expr, $($text:tt)+) => {
        $cx.log($crate::Severity::Error, ::core::format_args!($($text)+))
    };
}
