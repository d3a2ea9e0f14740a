//! Reads the events of earlier versions of jde, whose messages have only words. This is the one place where a program reads
//! what was written for people.

use std::path::PathBuf;

use jde_core::{Health, Nanos};

use crate::event::{Loss, OperatorAction, Outcome, What};
use crate::reload::BuildName;
use crate::resource_usage::ResourceUsage;
use crate::wire::{EventMessage, GestureMessage};

/// Returns what a message of an earlier version says. `None` if no version wrote these words.
pub(crate) fn what(time: Nanos, message: &EventMessage) -> Option<What<String>> {
    let text = message.text.as_str();
    let schema = || message.schema.clone();
    let health = |health| {
        Some(What::HealthChanged {
            schema: schema()?,
            health,
        })
    };
    let before = |duration: Nanos| time.saturating_sub(duration);
    match message.kind.as_str() {
        "ok" => health(Health::Ok),
        "arbitration-failed" => health(Health::ArbitrationFailed(text.to_owned())),
        "faulted" => health(Health::Faulted(text.to_owned())),
        "overrun" => match words("took {} ms of {} ms", text) {
            Some([took, budget]) => Some(What::Overrun {
                schema: schema()?,
                took: ms(took)?,
                budget: ms(budget)?,
            }),
            None => health(Health::Overrun),
        },
        "hung" => {
            let [ago] = words("a call has not returned for {} ms", text)?;
            Some(What::Hung {
                schema: schema()?,
                since: before(ms(ago)?),
            })
        }
        "left-behind" => {
            let [ago, abandoned, bytes, files, memory] = words(
                "the call that began {} s ago is left behind, {} in all; it keeps {} bytes of shared values; the process has \
                 {} files open, {} MB of memory",
                text,
            )?;
            Some(What::CallAbandoned {
                schema: schema()?,
                since: before(s(ago)?),
                abandoned: abandoned.parse().ok()?,
                retained_bytes: bytes.parse().ok()?,
                process: resources(files, memory)?,
            })
        }
        "came-back" => {
            let [ago, abandoned, files, memory] = words(
                "a call that was left behind returned after {} s, and its instance ended; {} have not returned; the process has \
                 {} files open, {} MB of memory",
                text,
            )?;
            Some(What::AbandonedCallReturned {
                schema: schema()?,
                since: before(s(ago)?),
                abandoned: abandoned.parse().ok()?,
                process: resources(files, memory)?,
            })
        }
        "late" | "delayed" => takeover(schema()?, text, message.kind == "late"),
        "chatters" => {
            let [group, first, second, switches] =
                words("{} chatters between {} and {}: {} switches within a second", text)?;
            Some(What::ChatteringStarted {
                group: group.to_owned(),
                between: [first, second].map(|name| (name != "nobody").then(|| name.to_owned())),
                switches: switches.parse().ok()?,
            })
        }
        "calmed" => {
            let [group, ago, switches] = words("{} has calmed down after {} s and {} more switches", text)?;
            Some(What::ChatteringEnded {
                group: group.to_owned(),
                since: before(s(ago)?),
                switches: switches.parse().ok()?,
            })
        }
        "stands-still" => words("time stands still: {}", text).map(|[reason]| What::StoodStill {
            reason: reason.to_owned(),
        }),
        "stalled" => {
            let [ago, distance, reached] = words(
                "the mission has come no nearer for {} s: {} m from its target, {} reached",
                text,
            )?;
            Some(What::Stalled {
                schema: schema()?,
                since: before(s(ago)?),
                distance: distance.parse().ok()?,
                reached: reached.parse().ok()?,
            })
        }
        "refused" => Some(What::Refused {
            schema: schema()?,
            description: text.to_owned(),
            retry: None,
        }),
        "limited" => Some(What::Limited {
            schema: schema()?,
            description: text.to_owned(),
        }),
        "operator" | "drag" => operator(message),
        "retracted" => words("the value of {} was taken back", text).map(|[variable]| What::Retracted {
            variable: variable.to_owned(),
        }),
        "trigger" => Some(What::Triggered {
            condition: text.to_owned(),
        }),
        "reload-undone" => {
            let [build, reason] = words("goes on with the build before {}: {}", text)?;
            Some(What::ReloadRolledBack {
                schema: schema()?,
                build: build_name(build),
                reason: reason.to_owned(),
            })
        }
        "ended" => Some(What::Ended {
            outcome: Outcome::parse(text),
        }),
        // How a build took over was told in part.
        _ => None,
    }
}

fn takeover(schema: String, text: &str, is_late: bool) -> Option<What<String>> {
    let (text, machine) = match words("{}; the machine began turns {} ms late", text) {
        Some([text, late]) => (text, ms(late)?),
        None => (text, 0),
    };
    let [group, latency, allowed] =
        words("took over in {} after {} ms, and its contract allows {} ms", text)?;
    let (latency, allowed) = (ms(latency)?, ms(allowed)?);
    // They were told in whole us, and the kind from ns.
    let most = allowed.saturating_add(machine);
    let latency = if is_late {
        latency.max(most.saturating_add(1))
    } else {
        latency.min(most)
    };
    Some(What::TookOver {
        group: group.to_owned(),
        // It was not told.
        record: 0,
        schema,
        latency,
        allowed,
        machine,
    })
}

fn operator(message: &EventMessage) -> Option<What<String>> {
    let by = message.by.clone()?;
    let words_of_action = message.text.strip_prefix(&*by)?.strip_prefix(' ')?;
    let went_on = |one_step| What::WentOn {
        by: by.clone(),
        one_step,
    };
    let Some(schema) = message.schema.clone() else {
        return match words_of_action {
            "made a step" => Some(went_on(true)),
            "let time pass again" => Some(went_on(false)),
            _ => None,
        };
    };
    let mut parts = words_of_action.split("; ");
    let mut action_words = parts.next()?;
    let losses: Option<Vec<_>> = parts
        .map(|part| {
            words("{} loses its {}", part).map(|[reader, import]| Loss {
                reader: reader.to_owned(),
                import: import.to_owned(),
            })
        })
        .collect();
    let losses = losses.unwrap_or_else(|| {
        action_words = words_of_action;
        Vec::new()
    });
    let action = match &message.touched {
        Some(GestureMessage { number, gesture }) => OperatorAction::Touch {
            schema,
            number: *number,
            gesture: gesture.clone(),
        },
        None => action(schema, action_words)?,
    };
    Some(What::Operator { by, action, losses })
}

fn action(schema: String, text: &str) -> Option<OperatorAction<String>> {
    let (verb, rest) = text.split_once(' ')?;
    // What follows the name of the schema; one word more for a period.
    let own = |text: &str| text.strip_prefix(&*schema).map(str::to_owned);
    let rest = match rest.strip_prefix("the period of ") {
        Some(period) => {
            let rest = own(period)?;
            let [period] = words(" to {} s", &rest)?;
            return Some(OperatorAction::Period {
                period: s(period)?,
                schema,
            });
        }
        None => own(rest)?,
    };
    match (verb, rest.as_str()) {
        ("played", "") => Some(OperatorAction::Play { schema }),
        ("stopped", "") => Some(OperatorAction::Stop { schema }),
        ("forced", "") => Some(OperatorAction::Force { schema }),
        ("released", "") => Some(OperatorAction::Release { schema }),
        ("unloaded", "") => Some(OperatorAction::Unload { schema }),
        ("loaded", "") => Some(OperatorAction::Load { schema }),
        ("reloads", rest) => Some(OperatorAction::Reload {
            schema,
            build: build_name(rest.strip_prefix(": ")?),
        }),
        ("set", rest) => words(".{} to {}", rest).map(|[variable, value]| OperatorAction::Modulate {
            schema,
            variable: variable.to_owned(),
            value: value.to_owned(),
        }),
        ("lets", rest) => words(".{} fail: {}", rest).map(|[export, fault]| OperatorAction::Fail {
            schema,
            export: export.to_owned(),
            fault: fault.to_owned(),
        }),
        ("repaired", rest) => rest.strip_prefix('.').map(|export| OperatorAction::Repair {
            schema,
            export: export.to_owned(),
        }),
        _ => None,
    }
}

fn build_name(text: &str) -> BuildName {
    match text.split_once(" from ") {
        Some((version, file)) => BuildName {
            version: version.to_owned(),
            file: Some(PathBuf::from(file)),
        },
        None => BuildName {
            version: text.to_owned(),
            file: None,
        },
    }
}

fn resources(files: &str, megabytes: &str) -> Option<ResourceUsage> {
    Some(ResourceUsage {
        files: files.parse().ok()?,
        memory: scaled(megabytes, 1e6)?,
    })
}

fn ms(text: &str) -> Option<Nanos> {
    scaled(text, 1e6)
}

fn s(text: &str) -> Option<Nanos> {
    scaled(text, 1e9)
}

fn scaled(text: &str, unit: f64) -> Option<u64> {
    let number: f64 = text.parse().ok()?;
    (0.0..=1e10)
        .contains(&number)
        .then(|| (number * unit).round() as u64)
}

/// Returns what stands for each `{}` of a pattern, each as short as possible. `None` if the text has another pattern.
fn words<'t, const COUNT: usize>(pattern: &str, text: &'t str) -> Option<[&'t str; COUNT]> {
    let mut parts = pattern.split("{}");
    let mut rest = text.strip_prefix(parts.next()?)?;
    let mut found = [""; COUNT];
    for (number, place) in found.iter_mut().enumerate() {
        let after = parts.next()?;
        let end = if number + 1 == COUNT {
            rest.len()
                .checked_sub(after.len())
                .filter(|end| rest.get(*end..) == Some(after))
        } else {
            rest.find(after)
        }?;
        (*place, rest) = (&rest[..end], &rest[end + after.len()..]);
    }
    Some(found)
}

#[cfg(test)]
mod tests;
