use backseat_campaign::{Crew, Folder, Plan};

use crate::ReportError;
use crate::gallery::Gallery;
use crate::outcome::Outcomes;
use crate::page::page;

/// The report in a results folder.
pub const REPORT: &str = "report.html";

/// Writes the report of a whole campaign into its folder. With a crew it has pictures of runs, which are flown again.
/// Returns why some of them could not be.
///
/// # Errors
///
/// [`ReportError`] if the results cannot be read, a chart cannot be drawn, or the page cannot be written.
pub fn write(folder: &Folder, plan: &Plan, crew: Option<&Crew>) -> Result<Option<String>, ReportError> {
    let outcomes = Outcomes::read(folder, plan)?;
    let gallery = match crew {
        Some(crew) => Gallery::draw(&outcomes, plan, crew)?,
        None => Gallery::default(),
    };
    let text = page(folder, plan, &outcomes, &gallery)?;
    let lacking = gallery.lacking;
    let path = folder.path().join(REPORT);
    let temporary = folder.path().join(format!(".{REPORT}.{}", std::process::id()));
    std::fs::write(&temporary, text)
        .and_then(|()| std::fs::rename(&temporary, &path))
        .map_err(|source| ReportError::Write { path, source })?;
    Ok(lacking)
}
