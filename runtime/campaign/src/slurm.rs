use std::path::Path;

use crate::plan::word;

/// A job of the Slurm workload manager that flies a campaign as an array of shards, and merges them when all are done.
#[derive(Clone, Debug)]
pub struct Slurm<'a> {
    /// The program, on a path that every node has.
    pub program: &'a Path,
    /// The arguments of `backseat campaign` that the shards get, without `--shard`, `--out` and `--stop-after`.
    pub arguments: &'a [String],
    /// The results folder, on a path that every node has.
    pub out: &'a Path,
    /// How many shards there are.
    pub shards: u64,
    /// The cores of a task.
    pub cores: u32,
    /// The time that a task may take, minutes.
    pub minutes: u64,
    /// The exit code of a shard that was stopped before its end and goes on with the same command.
    pub stopped: u8,
    /// Further lines for `#SBATCH`, such as `--partition=short`.
    pub options: &'a [String],
}

/// A task is told to stop this long before its time is over, seconds.
const STOP_BEFORE_S: u64 = 60;

impl Slurm<'_> {
    /// The script of the array job. A task flies a shard. If its time is over, or its node is taken away, it goes on as
    /// the same task.
    #[must_use]
    pub fn array_script(&self) -> String {
        let out = word(&self.out.display().to_string());
        let mut text = String::from("#!/bin/bash\n");
        for option in [
            "--job-name=campaign".to_owned(),
            format!("--array=1-{}", self.shards),
            format!("--cpus-per-task={}", self.cores),
            format!("--time={}", self.minutes),
            "--requeue".to_owned(),
            // Slurm appends to the output of a task that goes on.
            "--open-mode=append".to_owned(),
            format!("--signal=TERM@{STOP_BEFORE_S}"),
            output(self.out, "%A_%a.txt"),
        ]
        .iter()
        .chain(self.options)
        {
            text.push_str(&format!("#SBATCH {option}\n"));
        }
        text.push_str(&format!(
            "\n# A task flies one shard. Exit code {stopped}: it was stopped before its end, and goes on when its turn comes again. So\n\
             # does a task whose program was killed, a few times.\n\
             srun --ntasks=1 {} campaign {} --shard \"$SLURM_ARRAY_TASK_ID/{}\" --out {out} --workers {}\n\
             code=$?\n\
             if [ $code -eq {stopped} ] || {{ [ $code -gt 128 ] && [ \"${{SLURM_RESTART_COUNT:-0}}\" -lt {RESTARTS} ]; }}; then\n    \
             scontrol requeue \"${{SLURM_ARRAY_JOB_ID}}_${{SLURM_ARRAY_TASK_ID}}\"\n    exit 0\nfi\n\
             exit $code\n",
            word(&self.program.display().to_string()),
            self.arguments.iter().map(|argument| word(argument)).collect::<Vec<_>>().join(" "),
            self.shards,
            self.cores,
            stopped = self.stopped,
        ));
        text
    }

    /// The script of the job that merges the shards and writes the report.
    #[must_use]
    pub fn merge_script(&self) -> String {
        let out = word(&self.out.display().to_string());
        let mut text = String::from("#!/bin/bash\n");
        for option in [
            "--job-name=campaign-merge".to_owned(),
            "--cpus-per-task=1".to_owned(),
            "--time=60".to_owned(),
            output(self.out, "merge.txt"),
        ]
        .iter()
        .chain(self.options)
        {
            text.push_str(&format!("#SBATCH {option}\n"));
        }
        text.push_str(&format!(
            "\nexec {} campaign merge {out}\n",
            word(&self.program.display().to_string())
        ));
        text
    }
}

/// Where the output of a job goes. `sbatch` reads quotes and backslashes in its lines, and a percent sign.
fn output(out: &Path, name: &str) -> String {
    let folder = out.display().to_string().replace('%', "%%");
    let folder = folder.replace('\\', r"\\").replace('"', r#"\""#);
    format!("--output=\"{folder}/slurm/{name}\"")
}

/// A task whose program is killed is started again so often.
const RESTARTS: u32 = 5;
