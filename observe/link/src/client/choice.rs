//! Chooses an application among those found, by name. Communicates with none.

use crate::Error;
use crate::message::About;

/// The index of the application that a name selects; without a name, of the only one.
pub(super) fn choose(running: &[&About], name: Option<&str>, whereabouts: &str) -> Result<usize, Error> {
    let Some(name) = name else {
        return match running {
            [] => Err(Error::NoApplication(whereabouts.to_owned())),
            [_] => Ok(0),
            several => Err(Error::Ambiguous(distinct(several))),
        };
    };
    let (requested, id) = parts(name);
    let fits = |index: &usize| is_match(running[*index], requested, id);
    let indices: Vec<usize> = (0..running.len()).filter(fits).collect();
    match indices.as_slice() {
        [index] => Ok(*index),
        [] => {
            let names = distinct(running);
            let plain = running.iter().map(|about| about.name.as_str());
            Err(Error::UnknownApplication {
                name: name.to_owned(),
                nearest: jde_nearest::nearest(requested, plain).map(str::to_owned),
                running: names,
            })
        }
        several => {
            let several: Vec<_> = several.iter().map(|index| running[*index]).collect();
            Err(Error::Ambiguous(distinct(&several)))
        }
    }
}

/// Splits `name@id` into the name and the beginning of the id. An empty part matches any.
pub(super) fn parts(name: &str) -> (&str, &str) {
    name.split_once('@').unwrap_or((name, ""))
}

/// Whether an application has this name, and an id with this beginning.
pub(super) fn is_match(about: &About, name: &str, id: &str) -> bool {
    (name.is_empty() || about.name == name) && about.id.starts_with(id)
}

/// Names that distinguish each application from the others.
fn distinct(running: &[&About]) -> Vec<String> {
    let name = |about: &&About| {
        let same = |other: &&&About| other.name == about.name;
        if running.iter().filter(same).count() > 1 {
            format!(
                "{}@{} (on {})",
                about.name,
                about.id.chars().take(6).collect::<String>(),
                about.host
            )
        } else {
            about.name.clone()
        }
    };
    running.iter().map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn about(name: &str, id: &str) -> About {
        About {
            host: "base".to_owned(),
            ..crate::folder::runtime_folder::tests::about(name, id)
        }
    }

    fn chosen(running: &[About], name: Option<&str>) -> Result<usize, String> {
        let running: Vec<_> = running.iter().collect();
        choose(&running, name, "nearby").map_err(|error| error.to_string())
    }

    #[test]
    fn a_single_application_needs_no_name() {
        let single = [about("robot1", "aa")];
        assert_eq!(chosen(&single, None), Ok(0));
        let two = [about("robot1", "aa"), about("robot2", "bb")];
        assert_eq!(
            chosen(&two, None),
            Err("several applications run: robot1, robot2; name one".to_owned())
        );
        assert_eq!(chosen(&two, Some("robot2")), Ok(1));
        assert_eq!(
            chosen(&[], None),
            Err("no application runs nearby; start one with `jde run`".to_owned())
        );
    }

    #[test]
    fn an_unknown_name_is_refused_with_the_most_similar_one() {
        let two = [about("robot1", "aa"), about("base", "bb")];
        assert_eq!(
            chosen(&two, Some("robto1")),
            Err("no application is called `robto1`; did you mean `robot1`?".to_owned())
        );
        assert_eq!(
            chosen(&two, Some("zebra")),
            Err("no application is called `zebra`; there are robot1, base".to_owned())
        );
    }

    #[test]
    fn applications_of_the_same_name_are_selected_by_id() {
        let two = [about("robot", "aaaaaaaa"), about("robot", "abbbbbbb")];
        assert_eq!(
            chosen(&two, Some("robot")),
            Err(
                "several applications run: robot@aaaaaa (on base), robot@abbbbb (on base); name one"
                    .to_owned()
            )
        );
        assert_eq!(chosen(&two, Some("robot@ab")), Ok(1));
        assert_eq!(chosen(&two, Some("@aa")), Ok(0));
        assert!(chosen(&two, Some("robot@c")).is_err());
    }
}
