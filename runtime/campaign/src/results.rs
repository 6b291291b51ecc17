use std::collections::{BTreeMap, BTreeSet};

use crate::design::Value;
use crate::error::CampaignError;
use crate::folder::{Folder, RUNS, TIMING};
use crate::journal::{Journal, Place};
use crate::parquet_file::{ColumnKind, Sheet, Table};
use crate::plan::{Key, Plan};
use crate::row::{COLUMNS, Cell};

/// The results of a campaign, written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Finished {
    /// How many rows they have.
    pub runs: u64,
    /// Of those, met every expectation.
    pub passed: u64,
    /// Of those, could not be flown.
    pub not_flown: u64,
    /// Violations in all of them.
    pub violations: u64,
}

/// Writes `runs.parquet` and `timing.parquet` of a whole campaign into a folder, from the journals in `folders`.
///
/// # Errors
///
/// [`CampaignError`] if a run is missing or there twice, if the folders are of different campaigns, or if a file cannot
/// be read or written.
pub fn finish(plan: &Plan, folders: &[Folder], out: &Folder) -> Result<Finished, CampaignError> {
    let journals = read(folders, out)?;
    let index = index(plan, &journals, out)?;
    let sheet = Columns::new(plan, &journals);
    out.remove_unfinished();
    let facts = [("campaign", out.manifest()?.identity())];
    let mut runs = Table::create(&out.path().join(RUNS), &sheet.sheet, &facts)?;
    let mut timing = Table::create(&out.path().join(TIMING), &timing_sheet(), &facts)?;
    let mut finished = Finished::default();
    let mut bytes = Vec::new();
    let mut row = vec![None; sheet.sheet.columns.len()];
    for (run, (journal, place)) in (0..).zip(&index) {
        let journal = &journals[*journal as usize];
        let Some(key) = plan.key(run) else { break };
        let (wall_ns, cells) = journal.row(place, &mut bytes)?;
        sheet.fill(&mut row, plan, &key, journal, cells);
        finished.runs += 1;
        finished.passed += u64::from(row[sheet.of("passed")] == Some(Cell::Boolean(true)));
        finished.not_flown += u64::from(row[sheet.of("error")].is_some());
        if let Some(Cell::Integer(count)) = row[sheet.of("violations")] {
            finished.violations += count.cast_unsigned();
        }
        runs.write(&row)?;
        timing.write(&[
            Some(integer(run)),
            Some(Cell::Number(wall_ns as f64 / 1e9)),
            Some(Cell::Text(journal.host(place).to_owned())),
            Some(Cell::Text(
                journal
                    .path()
                    .file_stem()
                    .unwrap_or_default()
                    .to_string_lossy()
                    .into_owned(),
            )),
        ])?;
    }
    runs.finish()?;
    timing.finish()?;
    Ok(finished)
}

/// How many runs are not flown yet; those that several shards have flown count once.
///
/// # Errors
///
/// [`CampaignError`] if a journal cannot be read.
pub fn pending(plan: &Plan, folder: &Folder) -> Result<u64, CampaignError> {
    let journals = read(std::slice::from_ref(folder), folder)?;
    let mut flown: Vec<u64> = journals
        .iter()
        .flat_map(|journal| &journal.rows)
        .map(|place| place.run)
        .collect();
    flown.sort_unstable();
    flown.dedup();
    Ok(plan.runs().saturating_sub(flown.len() as u64))
}

fn read(folders: &[Folder], out: &Folder) -> Result<Vec<Journal>, CampaignError> {
    let ours = out.manifest()?;
    let identity = ours.identity();
    let mut journals = Vec::new();
    let mut known = BTreeSet::new();
    for folder in folders {
        let place = folder
            .path()
            .canonicalize()
            .unwrap_or_else(|_| folder.path().to_path_buf());
        if !known.insert(place) {
            return Err(CampaignError::folder(
                folder.path(),
                "is given twice: give each folder once",
            ));
        }
        if let Some(difference) = folder.manifest()?.difference(&ours) {
            return Err(CampaignError::folder(
                folder.path(),
                format!(
                    "has results of another campaign than {}: {difference}",
                    out.path().display()
                ),
            ));
        }
        for path in folder.all_journals()? {
            journals.push(Journal::read(&path, &identity)?);
        }
    }
    Ok(journals)
}

/// For each run the journal that has it, and its place there.
fn index(plan: &Plan, journals: &[Journal], out: &Folder) -> Result<Vec<(u32, Place)>, CampaignError> {
    let rows: u64 = journals.iter().map(|journal| journal.rows.len() as u64).sum();
    if rows < plan.runs() {
        // Without a table of all runs, of which there may be very many.
        let mut flown: Vec<u64> = journals
            .iter()
            .flat_map(|journal| &journal.rows)
            .map(|place| place.run)
            .collect();
        flown.sort_unstable();
        flown.dedup();
        return Err(lacking(out, journals, &flown, plan.runs()));
    }
    let mut index: Vec<Option<(u32, Place)>> = vec![None; plan.runs() as usize];
    for (number, journal) in (0..).zip(journals) {
        for place in &journal.rows {
            let Some(slot) = index.get_mut(place.run as usize) else {
                return Err(CampaignError::folder(
                    journal.path(),
                    format!("has run {}, and the campaign has {} runs", place.run, plan.runs()),
                ));
            };
            match slot {
                Some((other, _)) if *other != number => {
                    return Err(CampaignError::folder(
                        journal.path(),
                        format!(
                            "has run {} twice, because {} has it too: remove one of the two",
                            place.run,
                            journals[*other as usize].path().display()
                        ),
                    ));
                }
                // The same process flew it again: the rows are equal.
                slot => *slot = Some((number, *place)),
            }
        }
    }
    let whole: Option<Vec<_>> = index.iter().copied().collect();
    whole.ok_or_else(|| {
        let flown = (0..).zip(&index).filter(|(_, there)| there.is_some());
        let flown: Vec<u64> = flown.map(|(run, _)| run).collect();
        lacking(out, journals, &flown, plan.runs())
    })
}

fn lacking(out: &Folder, journals: &[Journal], flown: &[u64], runs: u64) -> CampaignError {
    let damaged = journals.iter().filter(|journal| journal.damaged > 0);
    let damaged: Vec<String> = damaged
        .map(|journal| format!("; {} is damaged", journal.path().display()))
        .collect();
    CampaignError::folder(
        out.path(),
        format!(
            "runs are missing: {}{}: fly them with the same command as the others, or give their folder to `campaign \
             merge`",
            gaps(flown, runs),
            damaged.concat()
        ),
    )
}

/// The ranges of runs that are not among these sorted ones, as text; the first few of them.
fn gaps(flown: &[u64], runs: u64) -> String {
    const SHOWN: usize = 5;
    let mut ranges: Vec<(u64, u64)> = Vec::new();
    let mut next = 0;
    for run in flown.iter().copied().chain([runs]) {
        if run > next {
            ranges.push((next, run - 1));
        }
        next = run + 1;
    }
    let count: u64 = ranges.iter().map(|(first, last)| last - first + 1).sum();
    let shown: Vec<String> = ranges
        .iter()
        .take(SHOWN)
        .map(|(first, last)| {
            if first == last {
                first.to_string()
            } else {
                format!("{first}..{last}")
            }
        })
        .collect();
    let more = if ranges.len() > SHOWN { ", ..." } else { "" };
    format!("{count} of them ({}{more})", shown.join(", "))
}

/// Where the cells of a row go.
struct Columns {
    sheet: Sheet,
    places: BTreeMap<String, usize>,
    /// The first parameter's place, and how many there are.
    parameters: std::ops::Range<usize>,
}

/// The columns that follow from a run's number.
const KEYS: [(&str, ColumnKind); 5] = [
    ("run", ColumnKind::Integer),
    ("mission", ColumnKind::Text),
    ("variant", ColumnKind::Text),
    ("point", ColumnKind::Integer),
    ("seed", ColumnKind::Natural),
];

impl Columns {
    fn new(plan: &Plan, journals: &[Journal]) -> Self {
        let mut columns: Vec<(String, ColumnKind)> = KEYS.map(|(name, kind)| (name.to_owned(), kind)).to_vec();
        let first = columns.len();
        for (place, name) in plan.parameters().enumerate() {
            columns.push((name.to_owned(), kind_of_parameter(plan, place)));
        }
        let parameters = first..columns.len();
        columns.extend(COLUMNS.map(|name| (name.to_owned(), kind_of(name))));
        let known: BTreeSet<&str> = COLUMNS.into_iter().collect();
        let measured: BTreeSet<&String> = journals
            .iter()
            .flat_map(|journal| journal.columns())
            .filter(|name| !known.contains(name.as_str()))
            .collect();
        columns.extend(measured.into_iter().map(|name| (name.clone(), ColumnKind::Number)));
        let places = columns.iter().enumerate();
        Self {
            // A parameter's key cannot be the name of a measure: it has a dot, and does not begin as they do.
            places: places.map(|(place, (name, _))| (name.clone(), place)).collect(),
            sheet: Sheet { columns },
            parameters,
        }
    }

    fn of(&self, name: &str) -> usize {
        self.places[name]
    }

    fn fill(&self, row: &mut [Option<Cell>], plan: &Plan, key: &Key, journal: &Journal, cells: Vec<(u32, Cell)>) {
        row.fill(None);
        row[0] = Some(integer(key.run));
        row[1] = Some(Cell::Text(plan.mission(key).display().to_string()));
        row[2] = Some(Cell::Text(plan.variant(key).to_owned()));
        row[3] = Some(integer(key.point));
        row[4] = Some(Cell::Natural(key.seed));
        for (place, value) in self.parameters.clone().zip(plan.values(key)) {
            row[place] = Some(cell_of(&value, self.sheet.columns[place].1));
        }
        for (column, cell) in cells {
            let place = journal
                .columns()
                .get(column as usize)
                .and_then(|name| self.places.get(name));
            if let Some(place) = place {
                row[*place] = Some(cell);
            }
        }
    }
}

fn integer(value: u64) -> Cell {
    Cell::Integer(i64::try_from(value).unwrap_or(i64::MAX))
}

fn kind_of(name: &str) -> ColumnKind {
    match name {
        "passed" => ColumnKind::Boolean,
        "outcome" | "error" | "unmet" | "rules_broken" | "first_failure" | "digest" | "replay" => ColumnKind::Text,
        name if name.ends_with("_s") => ColumnKind::Number,
        _ => ColumnKind::Integer,
    }
}

/// The type that all values of a parameter have: numbers if some are whole and some are not, text if they are of
/// different sorts.
fn kind_of_parameter(plan: &Plan, place: usize) -> ColumnKind {
    let one = |value: &Value| match value {
        Value::Boolean(_) => ColumnKind::Boolean,
        Value::Integer(_) => ColumnKind::Integer,
        Value::Number(_) => ColumnKind::Number,
        Value::Text(_) => ColumnKind::Text,
    };
    let kinds = plan
        .samples(place)
        .iter()
        .map(one)
        .fold(None, |all, kind| match (all, kind) {
            (None, kind) => Some(kind),
            (Some(all), kind) if all == kind => Some(all),
            (Some(ColumnKind::Integer | ColumnKind::Number), ColumnKind::Integer | ColumnKind::Number) => {
                Some(ColumnKind::Number)
            }
            _ => Some(ColumnKind::Text),
        });
    kinds.unwrap_or(ColumnKind::Text)
}

fn cell_of(value: &Value, kind: ColumnKind) -> Cell {
    match (value, kind) {
        (Value::Boolean(value), ColumnKind::Boolean) => Cell::Boolean(*value),
        (Value::Integer(value), ColumnKind::Integer | ColumnKind::Number) => Cell::Integer(*value),
        (Value::Number(value), ColumnKind::Number) => Cell::Number(*value),
        (value, _) => Cell::Text(value.to_string()),
    }
}

fn timing_sheet() -> Sheet {
    let columns = [
        ("run", ColumnKind::Integer),
        ("wall_s", ColumnKind::Number),
        ("host", ColumnKind::Text),
        ("shard", ColumnKind::Text),
    ];
    Sheet {
        columns: columns.map(|(name, kind)| (name.to_owned(), kind)).to_vec(),
    }
}
