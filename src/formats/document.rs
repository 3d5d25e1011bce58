//! Model files: a text, perhaps with files next to it, or an archive.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::table::{self, Frame, RewardFiles};
use crate::umb::archive::{self, Files};
use meliora_base::error::{Diagnostic, Error, Result, Severity, SourceFile};
use meliora_base::progress::ProgressSink;
use meliora_base::reading;
use meliora_lang::ast::Item;
use meliora_lang::names::displayed;
use meliora_lang::{Checked, Given, parse_model};

/// A model file as it was read. Its format is told by its content.
#[derive(Debug, Clone)]
pub struct Document {
    /// The text; for an archive, a text with its hash.
    source: Arc<SourceFile>,
    /// The bytes of an archive.
    archive: Option<Arc<Vec<u8>>>,
    /// For transitions of PRISM: the values and the labels of states.
    beside: [Option<Arc<SourceFile>>; 2],
    /// For each reward structure next to transitions of PRISM: the rewards of states, and of transitions.
    rewards: Vec<RewardFiles>,
    /// For a planning problem in two files: the domain and the problem.
    parts: Vec<Arc<SourceFile>>,
    /// True if only the goals of a planning problem are asked about.
    for_goals: bool,
}

impl Document {
    /// Reads a file. For transitions in PRISM's explicit format (`model.tra`), reads `model.sta` and
    /// `model.lab` as well if they exist, and the rewards of `model.srew` and `model.trew`, unless the file has states or labels itself (`model.pexp`).
    ///
    /// # Errors
    /// A file cannot be read, has more than 256 MiB, or is neither an archive nor UTF-8; a file next to
    /// the transitions is not a regular one.
    pub fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(|e| Error::reading(path, &e))?;
        let mut document = Self::read(path.display().to_string(), file)?;
        let source = &document.source;
        if document.archive.is_none() && table::is_tra(source) && !table::has_states(source) {
            document.beside = [existing(path.with_extension("sta"))?, existing(path.with_extension("lab"))?];
            document.rewards = rewards_beside(path)?;
        }
        Ok(document)
    }

    /// Reads a model to its end; `name` is its name in messages.
    ///
    /// # Errors
    /// See [`Document::open`].
    pub fn read(name: impl Into<String>, from: impl Read) -> Result<Self> {
        let name = name.into();
        let bytes = reading::bytes(&name, from)?;
        if !archive::is_archive(&bytes) {
            return Ok(Self::new(reading::text(name, bytes)?));
        }
        let text = format!("archive of {} bytes, SHA-256 {}\n", bytes.len(), reading::sha256(&bytes));
        Ok(Document { archive: Some(Arc::new(bytes)), ..Self::new(SourceFile::new(name, text)) })
    }

    /// Returns the document of a text.
    pub fn new(source: Arc<SourceFile>) -> Self {
        let (beside, rewards, parts) = Default::default();
        Document { source, archive: None, beside, rewards, parts, for_goals: false }
    }

    /// Leaves out the facts of a planning problem on which no goal depends.
    #[must_use]
    pub fn for_goals(self) -> Self {
        Document { for_goals: true, ..self }
    }

    /// Returns the document of a planning problem in two texts, in any order.
    ///
    /// # Errors
    /// A text is in another language.
    pub fn of_parts(parts: [Arc<SourceFile>; 2]) -> Result<Self> {
        for source in &parts {
            // Of a text that begins as a list does, or of an empty one, the error has a place.
            let is_list = source.text.trim_start().starts_with(['(', ';']) || source.text.trim().is_empty();
            if !is_list && !meliora_pddl::is_pddl(&source.text) {
                let message =
                    format!("`{}` is not in PDDL, and only a planning problem has two files", source.name);
                return Err(Error::Usage(message));
            }
        }
        Ok(Document { parts: parts.to_vec(), ..Self::new(meliora_pddl::joined(&parts)) })
    }

    /// Adds the files next to the transitions of PRISM: the values and the labels of states.
    #[must_use]
    pub fn with_beside(self, beside: [Option<Arc<SourceFile>>; 2]) -> Self {
        Document { beside, ..self }
    }

    /// Returns the files next to the transitions of PRISM: the values and the labels of states.
    pub fn beside(&self) -> &[Option<Arc<SourceFile>>; 2] {
        &self.beside
    }

    /// Adds the reward structures next to the transitions of PRISM.
    #[must_use]
    pub fn with_rewards(self, rewards: Vec<RewardFiles>) -> Self {
        Document { rewards, ..self }
    }

    /// Returns the reward structures next to the transitions of PRISM: the rewards of states, and of transitions.
    pub fn rewards(&self) -> &[RewardFiles] {
        &self.rewards
    }

    /// Returns the text; for an archive, a text with its hash.
    pub fn source(&self) -> &SourceFile {
        &self.source
    }

    /// Returns the bytes of an archive; `None` for a text.
    pub fn archive(&self) -> Option<&[u8]> {
        self.archive.as_ref().map(|bytes| bytes.as_slice())
    }

    /// Returns the names of the constants that a model in PRISM's language declares; none for other
    /// models, and where the text is wrong.
    pub fn constants(&self) -> Vec<String> {
        if meliora_pddl::is_pddl(&self.source.text) {
            return Vec::new();
        }
        let items = parse_model(&self.source).map(|model| model.items).unwrap_or_default();
        let constant = |item| match item {
            Item::Const(constant) => Some(constant.name.name),
            _ => None,
        };
        items.into_iter().filter_map(constant).collect()
    }

    /// Reads the model and flattens it.
    ///
    /// # Errors
    /// The file is not a model; a limit.
    pub fn load(&self, given: &Given, sink: &dyn ProgressSink) -> Result<Checked> {
        let mut checked = self.checked(given, sink)?;
        checked.warnings.extend(self.texts().filter_map(SourceFile::encoding_warning));
        Ok(checked)
    }

    fn checked(&self, given: &Given, sink: &dyn ProgressSink) -> Result<Checked> {
        if !self.parts.is_empty() {
            return crate::problem(&self.parts, self.for_goals, given, sink);
        }
        if self.for_goals && meliora_pddl::is_pddl(&self.source.text) {
            return crate::problem(std::slice::from_ref(&self.source), true, given, sink);
        }
        self.refuse_language()?;
        let frame = Frame { source: &self.source, given, sink };
        let [values, labels] = self.beside.each_ref().map(Option::as_ref);
        let checked = match &self.archive {
            Some(bytes) => table::load_umb(&Files::unpack(&self.source.name, bytes, sink)?, &frame),
            None if values.or(labels).is_some() || !self.rewards.is_empty() => {
                table::load_tra(&frame, values, labels, &self.rewards)
            }
            None => return crate::load_given(&self.source, given, sink),
        };
        checked.map(displayed)
    }

    /// Refuses languages that are not read, by the names of their files.
    fn refuse_language(&self) -> Result<()> {
        let extension = Path::new(&self.source.name).extension().and_then(|e| e.to_str()).unwrap_or_default();
        let (language, help) = match extension {
            "rddl" => ("RDDL", "write it in PPDDL, or in PRISM's language"),
            "modest" => ("Modest", "`modest export-to-jani` writes JANI, which is read"),
            _ => return Ok(()),
        };
        let place = 0..self.source.text.find('\n').unwrap_or(self.source.text.len());
        let wrong = Diagnostic::new(&self.source, place, format!("{language} is not supported"));
        Err(wrong.severity(Severity::Unsupported).help(help).into())
    }

    /// Returns the texts.
    fn texts(&self) -> impl Iterator<Item = &Arc<SourceFile>> {
        let whole = self.parts.is_empty().then_some(&self.source);
        let rewards = self.rewards.iter().flatten().flatten();
        whole.into_iter().chain(self.beside.iter().flatten()).chain(rewards).chain(&self.parts)
    }
}

/// Reads a file if it exists.
fn existing(path: PathBuf) -> Result<Option<Arc<SourceFile>>> {
    if !path.exists() {
        return Ok(None);
    }
    let file = reading::regular(&path).map_err(|e| Error::reading(&path, &e))?;
    SourceFile::read(path.display().to_string(), file).map(Some)
}

/// Reads the rewards next to `m.tra`: `m.srew` and `m.trew`, or `m1.srew`, `m1.trew`, `m2.srew`, … of several structures.
fn rewards_beside(path: &Path) -> Result<Vec<RewardFiles>> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let of = |number: &str| -> Result<RewardFiles> {
        let file = |extension: &str| existing(path.with_file_name(format!("{stem}{number}.{extension}")));
        Ok([file("srew")?, file("trew")?])
    };
    let is_there = |files: &RewardFiles| files.iter().any(Option::is_some);
    let mut all = Vec::from_iter(Some(of("")?).filter(is_there));
    if all.is_empty() {
        for number in 1.. {
            let files = of(&number.to_string())?;
            if !is_there(&files) {
                break;
            }
            all.push(files);
        }
    }
    Ok(all)
}
