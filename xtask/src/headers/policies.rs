//! The table of policies in `docs/applications.md`, from the list in `jde_core`.

use std::fmt::Write;

use jde_core::POLICIES;

const BEGIN: &str = "<!-- policies: from rules/core/src/policy; `cargo xtask headers` renews them -->\n";
const END: &str = "<!-- end -->\n";

/// Returns the page with a new table. A page without the marks of a table stays as it is.
pub(super) fn renew(page: &str) -> String {
    let parts = page.split_once(BEGIN);
    let Some((before, Some((_, after)))) = parts.map(|(before, rest)| (before, rest.split_once(END))) else {
        return page.to_owned();
    };
    format!("{before}{BEGIN}{}{END}{after}", table())
}

fn table() -> String {
    let mut table = String::from("| policy | decides by | keys |\n|---|---|---|\n");
    for kind in POLICIES {
        let time = kind.time.iter().map(|time| format!("`{}`, a time", time.key));
        let number = kind.number.iter();
        let number = number.map(|number| format!("`{}`, {}", number.key, number.meaning));
        let keys: Vec<String> = time.chain(number).collect();
        let keys = if keys.is_empty() {
            "-".to_owned()
        } else {
            keys.join("; ")
        };
        let _ = writeln!(table, "| `{}` | {} | {keys} |", kind.name, kind.summary);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_table_is_renewed() {
        let page = |table: &str| format!("before\n{BEGIN}{table}{END}after\n");
        assert_eq!(renew(&page("old\n")), page(&table()));
        assert_eq!(renew("no table\n"), "no table\n");
        assert!(table().contains("| `sticky` | the winner stays"), "{}", table());
    }
}
