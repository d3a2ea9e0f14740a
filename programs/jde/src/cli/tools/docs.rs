//! `jde docs`: where the documentation of this installation is.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use clap::Args;
use jde_nearest::nearest;
use jde_session::paths;
use jde_terminal::{self as terminal, FAINT, TITLE};

use crate::failure::{Failure, display_path};

/// The program that opens a file as the desktop does.
const OPENER: &str = "xdg-open";

/// Show where the documentation is: its pages, or the file of one.
#[derive(Args)]
#[command(after_help = "Examples:
  jde docs                  all pages
  jde docs python           the file of a page
  jde docs python --open    opens it as the desktop opens such files")]
pub(in crate::cli) struct Docs {
    /// The page, such as python or tutorial/05-why.
    #[arg(value_name = "PAGE")]
    page: Option<String>,
    /// Open it, or the list of all pages.
    #[arg(long)]
    open: bool,
}

/// A page of the documentation.
struct Page {
    /// Its path below the folder, without the extension.
    name: String,
    file: PathBuf,
}

impl Docs {
    pub(super) fn run(self) -> Result<(), Failure> {
        let folder = paths::data().join("docs");
        let pages = pages(&folder);
        if pages.is_empty() {
            return Err(Failure::broken(format!(
                "{} has no pages: this program was moved away from its installation",
                display_path(&folder)
            )));
        }
        let mut out = terminal::out();
        let file = match &self.page {
            Some(name) => {
                let page = pages
                    .iter()
                    .find(|page| page.name == name.trim_end_matches(".md"));
                let page = page.ok_or_else(|| unknown(name, &pages))?;
                writeln!(out, "{}", page.file.display())?;
                page.file.clone()
            }
            None => {
                writeln!(out, "{TITLE}{}{TITLE:#}", folder.display())?;
                for page in pages.iter().filter(|page| page.name != "README") {
                    writeln!(out, "  {:<28} {FAINT}{}{FAINT:#}", page.name, title(&page.file))?;
                }
                folder.join("README.md")
            }
        };
        out.flush()?;
        if self.open {
            open(&file)?;
        }
        Ok(())
    }
}

/// Returns the pages of a folder and of the folders in it, in the order of their names.
fn pages(folder: &Path) -> Vec<Page> {
    let entries = |folder: &Path| -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        entries.map(|entry| entry.path()).collect()
    };
    let below = entries(folder).into_iter().filter(|path| path.is_dir());
    let files = below.flat_map(|path| entries(&path)).chain(entries(folder));
    let mut pages: Vec<_> = files
        .filter_map(|file| {
            let name = file.strip_prefix(folder).ok()?.to_str()?.strip_suffix(".md")?;
            Some(Page {
                name: name.to_owned(),
                file,
            })
        })
        .collect();
    pages.sort_by(|one, other| one.name.cmp(&other.name));
    pages
}

/// Returns wrong use because there is no such page. The advice is the nearest one in any folder, or those at the top.
fn unknown(name: &str, pages: &[Page]) -> Failure {
    let last = |page: &Page| page.name.rsplit('/').next().unwrap_or_default().to_owned();
    let lasts: Vec<String> = pages.iter().map(last).collect();
    let near = nearest(name, pages.iter().map(|page| page.name.as_str()));
    let near = near.or_else(|| {
        let end = lasts.iter().find(|end| *end == name).map(String::as_str);
        let end = end.or_else(|| nearest(name, lasts.iter().map(String::as_str)))?;
        let place = lasts.iter().position(|last| last == end)?;
        Some(pages[place].name.as_str())
    });
    if let Some(near) = near {
        return Failure::usage(
            format!("there is no page `{name}`"),
            format!("did you mean `{near}`?"),
        );
    }
    let names = pages.iter().map(|page| page.name.as_str());
    Failure::unknown("page", name, names.filter(|name| !name.contains('/')))
}

/// Returns the first line of a page, which is its title.
fn title(file: &Path) -> String {
    let text = fs::read_to_string(file).unwrap_or_default();
    let first = text.lines().next().unwrap_or_default();
    first.trim_start_matches('#').trim().to_owned()
}

/// Opens a file as the desktop does. Its program may stay open longer than this one.
fn open(file: &Path) -> Result<(), Failure> {
    let opener = Command::new(OPENER)
        .arg(file)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    opener.map(drop).map_err(|error| {
        Failure::usage(
            format!("`{OPENER}` cannot open {}: {error}", display_path(file)),
            "without a desktop, read the file, such as by `less`",
        )
    })
}
