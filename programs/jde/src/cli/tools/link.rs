//! The options of verbs that open a link: how tools connect to the run.

use clap::Args;

use crate::extensions::LinkOptions;

/// How tools connect.
#[derive(Args)]
pub(crate) struct Link {
    /// The name under which tools and other robots find it, instead of the application's.
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Let no tool connect, regardless of the application's file.
    #[arg(long, conflicts_with_all = ["name", "link"])]
    no_link: bool,
    /// Let tools connect also in lockstep, which usually ends before a tool can connect; with --break and
    /// --debug-python they can anyway.
    #[arg(long)]
    link: bool,
    /// Open windows beside it: oscilloscope, sensors and motors, 3D, panels.
    #[arg(long, conflicts_with = "no_link")]
    view: bool,
}

impl From<Link> for LinkOptions {
    fn from(link: Link) -> Self {
        Self {
            view: link.view,
            enabled: match (link.no_link, link.link || link.view || link.name.is_some()) {
                (true, _) => Some(false),
                (false, true) => Some(true),
                (false, false) => None,
            },
            name: link.name,
            page: None,
            stands_still: false,
        }
    }
}
