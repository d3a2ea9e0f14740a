//! Counts, shares and sizes as text.

/// Returns a number with its noun: "1 switch", "2 switches".
#[must_use]
pub fn counted(count: u64, noun: &str) -> String {
    let ending = match noun {
        _ if count == 1 => "",
        noun if noun.ends_with("ch") => "es",
        _ => "s",
    };
    format!("{count} {noun}{ending}")
}

/// Returns a share of 1 in whole percent.
#[must_use]
pub fn percent(share: f64) -> String {
    match share * 100.0 {
        share if share > 0.0 && share < 1.0 => "<1 %".to_owned(),
        share => format!("{:.0} %", share.abs()),
    }
}

/// Returns a number of bytes in the largest unit that fits.
#[must_use]
pub fn format_size(bytes: u64) -> String {
    match bytes {
        0..1_000 => format!("{bytes} B"),
        1_000..1_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", bytes as f64 / 1e6),
        _ => format!("{:.1} GB", bytes as f64 / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nouns_have_a_plural() {
        assert_eq!(counted(1, "switch"), "1 switch");
        assert_eq!(counted(2, "switch"), "2 switches");
        assert_eq!(counted(0, "event"), "0 events");
    }

    #[test]
    fn a_small_share_is_not_0() {
        assert_eq!(percent(0.004), "<1 %");
        assert_eq!(percent(0.0), "0 %");
        assert_eq!(percent(0.126), "13 %");
    }
}
