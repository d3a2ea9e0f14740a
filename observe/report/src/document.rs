//! The frame of a page: one self-contained HTML file that loads nothing, is readable without a script, and has
//! styles for light, dark and print. Escaped text never becomes markup. It knows no content.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use sha2::{Digest, Sha256};

use jde_drawing::style;

const STYLE: &str = include_str!("document.css");

/// A part of a page: its id, its title, and its content if there is any.
pub(crate) type Part = (&'static str, &'static str, Option<Markup>);

/// The content of a page.
pub(crate) struct Document<'a> {
    /// The title of the window.
    pub(crate) title: String,
    /// Rules beside those of all pages.
    pub(crate) style: &'static str,
    pub(crate) head: Markup,
    /// What follows the links to the parts.
    pub(crate) facts: Markup,
    pub(crate) parts: &'a [Part],
    pub(crate) footer: Markup,
    /// The only script that runs.
    pub(crate) script: Option<&'static str>,
}

impl Document<'_> {
    /// Renders the page.
    pub(crate) fn render(&self) -> String {
        // Markup has none of the characters that change the reading direction or hide text: those are of others.
        jde_files::escape_except(&self.markup().into_string(), &['\n', '\t'])
    }

    fn markup(&self) -> Markup {
        let style = format!("{}{STYLE}{}", style(), self.style);
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta http-equiv="Content-Security-Policy" content=(self.policy());
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { (self.title) }
                    style { (PreEscaped(style)) }
                }
                body {
                    main {
                        (self.head)
                        nav aria-label="Parts of this page" {
                            @for (id, title, part) in self.parts {
                                @if part.is_some() { a href={ "#" (id) } { (title) } }
                            }
                        }
                        (self.facts)
                        @for (id, title, part) in self.parts {
                            @if let Some(part) = part {
                                section id=(id) {
                                    h2 { (title) }
                                    (part)
                                }
                            }
                        }
                        footer { (self.footer) }
                    }
                    @if let Some(script) = self.script { script { (PreEscaped(script)) } }
                }
            }
        }
    }

    /// The content security policy: nothing is loaded, and only the page's own script runs, whatever the
    /// content is.
    fn policy(&self) -> String {
        let script = self.script.map(|script| {
            let hash = STANDARD.encode(Sha256::digest(script));
            format!(" script-src 'sha256-{hash}';")
        });
        format!(
            "default-src 'none'; style-src 'unsafe-inline';{} base-uri 'none'; form-action 'none'",
            script.unwrap_or_default()
        )
    }
}
