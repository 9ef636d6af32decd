//! What the launcher of parallel processes says in the environment.

use crate::{Error, Result};

/// Processes that were started together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Launch {
    /// How many.
    pub size: u32,
    /// The variable that says so.
    pub variable: &'static str,
}

/// Launchers' words for the number of processes, and the one that must be there, too, to believe it.
const WORDS: [(&str, Option<&str>); 4] = [
    ("OMPI_COMM_WORLD_SIZE", None),
    ("PMI_SIZE", None),
    ("MV2_COMM_WORLD_SIZE", None),
    // Slurm counts tasks of all steps; those of parallel programs have a rank.
    ("SLURM_STEP_NUM_TASKS", Some("PMIX_RANK")),
];

/// The variable that makes a process one of its own, whoever started it.
pub const SWITCH: &str = "SVETLO_MPI";

impl Launch {
    /// What the environment says; `None` where this process was started alone, or is to be taken so (`SVETLO_MPI=off`).
    ///
    /// # Errors
    /// [`Error::Input`] for a `SVETLO_MPI` that says anything else.
    pub fn of_environment() -> Result<Option<Self>> {
        Self::of(|name| std::env::var(name).ok())
    }

    fn of(variable: impl Fn(&str) -> Option<String>) -> Result<Option<Self>> {
        match variable(SWITCH).as_deref() {
            Some("off") => return Ok(None),
            None | Some("") => {}
            Some(other) => {
                return Err(Error::Input(format!(
                    "{SWITCH} is '{other}'; it may be 'off', for processes that do not work together"
                )));
            }
        }
        let size = |name| variable(name)?.trim().parse().ok().filter(|&size| size > 0);
        let word = |&(name, with): &(&'static str, Option<&str>)| {
            with.is_none_or(|other| variable(other).is_some()).then(|| size(name)).flatten()
        };
        Ok(WORDS.iter().find_map(|row| Some(Self { size: word(row)?, variable: row.0 })))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn launch(variables: &[(&str, &str)]) -> Result<Option<(u32, &'static str)>> {
        let value =
            |name: &str| variables.iter().find(|(key, _)| *key == name).map(|(_, value)| (*value).to_owned());
        Ok(Launch::of(value)?.map(|launch| (launch.size, launch.variable)))
    }

    #[test]
    fn launchers_are_known_by_their_variables() {
        let found = |variables: &[(&str, &str)]| launch(variables).unwrap();
        assert_eq!(found(&[]), None);
        assert_eq!(found(&[("OMPI_COMM_WORLD_SIZE", "4")]), Some((4, "OMPI_COMM_WORLD_SIZE")));
        assert_eq!(found(&[("PMI_SIZE", "2"), ("PMI_RANK", "0")]), Some((2, "PMI_SIZE")));
        assert_eq!(found(&[("OMPI_COMM_WORLD_SIZE", "many")]), None);
        // A job that runs one process, whatever it may run.
        assert_eq!(found(&[("SLURM_STEP_NUM_TASKS", "8")]), None);
        let srun = [("SLURM_STEP_NUM_TASKS", "8"), ("PMIX_RANK", "3")];
        assert_eq!(found(&srun), Some((8, "SLURM_STEP_NUM_TASKS")));
        assert_eq!(found(&[srun[0], srun[1], (SWITCH, "off")]), None);
        assert_eq!(found(&[srun[0], srun[1], (SWITCH, "")]), Some((8, "SLURM_STEP_NUM_TASKS")));
        assert!(launch(&[(SWITCH, "on")]).unwrap_err().to_string().contains("it may be 'off'"));
    }
}
