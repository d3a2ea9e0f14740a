//! The example for Slurm on a cluster of one node, whose daemons run for this test only: a job array, a part of
//! which is killed in the middle, and a job that joins the parts. Needs neither root nor systemd, and reads and
//! changes nothing of a Slurm that is installed for use.

use std::fs;
use std::net::TcpListener;
use std::process::Command;

use anyhow::{Result, ensure};

use super::{FILE, OUT_FOLDER, PART_COUNT, Trial, kill, poll, processes_with};
use crate::prerequisites;
use crate::shell::{self, ChildGuard};
use crate::step::StepOutcome;
use crate::test::Context;

const EXAMPLE: &str = "examples/clusters/slurm.sh";
/// The part whose process is killed.
const KILLED_PART: usize = 1;

pub(crate) fn run(context: &Context) -> Result<StepOutcome> {
    if !prerequisites::has_slurm() {
        return context.missing_tool("Slurm", prerequisites::INSTALL_SLURM);
    }
    let mut trial = Trial::start(context, "slurm")?;
    // The file by which all programs of Slurm find the trial's daemons, and no others.
    let file = trial.folder.join("slurm.conf");
    trial.variables.push(("SLURM_CONF", file.into()));
    let _daemons = start_daemons(&trial)?;
    fs::create_dir(trial.folder.join(OUT_FOLDER))?;
    let mut array = Command::new("sbatch");
    array
        .args(["--parsable", "--output=part-%a.log"])
        .arg(format!("--array=1-{PART_COUNT}"))
        .arg(context.root.join(EXAMPLE))
        .args([FILE, OUT_FOLDER]);
    let array = trial.read(&mut array)?;
    let array = array.trim();
    // It begins when no task is left, not even one that has returned to the queue.
    let mut merge = Command::new("sbatch");
    merge
        .args(["--wait", "--output=merge.log"])
        .arg(format!("--dependency=afterany:{array}"))
        .arg("--wrap")
        .arg(format!(
            "jde experiment merge {OUT_FOLDER}/part-*-of-{PART_COUNT} --out {OUT_FOLDER}/all"
        ));
    let mut merge = trial.spawn("sbatch", &mut merge)?;

    poll("the first result of a part", || {
        ensure!(
            merge.0.try_wait()?.is_none(),
            "the tasks ended without a result: see part-*.log"
        );
        Ok(trial.has_begun(KILLED_PART).then_some(()))
    })?;
    let folder = format!("{OUT_FOLDER}/part-{KILLED_PART}-of-{PART_COUNT}");
    let victim = processes_with("cmdline", &folder)?;
    ensure!(victim.len() == 1, "{} processes write {folder}", victim.len());
    kill(&victim);
    ensure!(
        !trial.has_ended(KILLED_PART),
        "the part ended before it was killed"
    );
    println!("killed `jde experiment` of a part");

    let status = poll("the end of the job that joins the parts", || {
        Ok(merge.0.try_wait()?)
    })?;
    ensure!(
        status.success(),
        "the job that joins the parts failed: see merge.log"
    );
    let mut state = Command::new("scontrol");
    state.args(["--oneliner", "show", "job"]);
    let killed = trial.read(state.arg(format!("{array}_{KILLED_PART}")))?;
    ensure!(
        killed.contains(" Restarts=1 "),
        "the killed task was not started again: {killed}"
    );
    trial.compare()?;
    Ok(StepOutcome::Passed)
}

/// Starts the daemons, and waits until the node takes jobs. The trial ends what they leave behind.
fn start_daemons(trial: &Trial<'_>) -> Result<Vec<ChildGuard>> {
    for folder in ["state", "spool"] {
        fs::create_dir(trial.folder.join(folder))?;
    }
    fs::write(trial.folder.join("slurm.conf"), configuration(trial)?)?;
    // Nothing uses it, but slurmd loads it: the one that looks at nothing when it is loaded.
    fs::write(trial.folder.join("cgroup.conf"), "CgroupPlugin=cgroup/v1\n")?;
    let file = |option: &str| {
        format!(
            "--{option}={}",
            trial.folder.join("munge").with_extension(option).display()
        )
    };
    trial.read(Command::new("mungekey").args(["--create", &file("keyfile")]))?;
    let key = format!("--key-file={}", trial.folder.join("munge.keyfile").display());
    let files = ["socket", "pid-file", "log-file", "seed-file"].map(file);
    let mut munged = Command::new("munged");
    // It would refuse a folder that others may write to.
    munged.args(["--foreground", "--force", &key]).args(files);
    let mut daemons = vec![
        trial.spawn("munged", &mut munged)?,
        trial.spawn("slurmctld", Command::new("slurmctld").arg("-D"))?,
        trial.spawn("slurmd", Command::new("slurmd").arg("-D"))?,
    ];
    poll("a node that takes jobs", || {
        for daemon in &mut daemons {
            ensure!(daemon.0.try_wait()?.is_none(), "a daemon ended: see its log");
        }
        // Fails until the controller listens.
        let mut states = Command::new("sinfo");
        states.args(["--noheader", "--format=%T"]);
        let states = trial.prepare(&mut states).output()?;
        Ok((states.stdout.trim_ascii() == b"idle").then_some(()))
    })?;
    Ok(daemons)
}

/// Returns a configuration of one node, which runs two tasks at a time whatever its processors.
fn configuration(trial: &Trial<'_>) -> Result<String> {
    let read = |program: &str, argument: &str| shell::read(Command::new(program).arg(argument));
    let (user, node) = (read("id", "-un")?, read("hostname", "-s")?);
    let (user, node) = (user.trim(), node.trim());
    let folder = trial.folder.display();
    // Free now, and nothing else of this step requests a port.
    let sockets = [
        TcpListener::bind("127.0.0.1:0")?,
        TcpListener::bind("127.0.0.1:0")?,
    ];
    let [controller, daemon] = [sockets[0].local_addr()?.port(), sockets[1].local_addr()?.port()];
    // `cred_expire` is also the time that a task waits in the queue before it starts again.
    Ok(format!(
        "ClusterName=jde-trial
SlurmctldHost={node}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={daemon}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=5
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
ReturnToService=2
SlurmdParameters=config_overrides
NodeName={node} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=trial Nodes={node} Default=YES MaxTime=INFINITE State=UP
"
    ))
}
