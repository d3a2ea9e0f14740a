//! `jde demo`: the demonstration, with a link for tools.

use clap::Args;
use jde_session::log::Filter;

use super::tools::Link;
use crate::extensions::LinkOptions;
use crate::failure::Failure;

#[derive(Args)]
pub(super) struct LinkedDemo {
    #[command(flatten, next_help_heading = "How tools connect")]
    link: Link,
    /// The last, whose words are those of the help.
    #[command(flatten, next_help_heading = None::<&str>)]
    demo: jde_session::demo::Demo,
}

impl LinkedDemo {
    pub(super) fn run(self, filter: Option<Filter>) -> Result<(), Failure> {
        let link = Box::new(LinkOptions::from(self.link));
        Ok(self.demo.run(filter, vec![link])?)
    }
}
