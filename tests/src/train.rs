//! One train of real processes.

use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, ExitStatus, Output, Stdio};
use std::time::{Duration, Instant};

use rustix::process::Signal;
use tempfile::TempDir;

use crate::{Http, Process, of_instance};

/// Asks `question` every 5 ms until it has an answer or the time is over.
pub fn within<T>(patience: Duration, mut question: impl FnMut() -> Option<T>) -> Option<T> {
    let deadline = Instant::now() + patience;
    loop {
        if let Some(answer) = question() {
            return Some(answer);
        }
        if Instant::now() >= deadline {
            return None;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A train in a folder of its own.
pub struct TrainUnderTest {
    program: PathBuf,
    folder: TempDir,
    options: Vec<String>,
    up: Option<Child>,
}

impl TrainUnderTest {
    /// Prepares a folder; nothing runs yet. `config` is the text of the train's config file.
    ///
    /// # Panics
    /// If the folder cannot be made.
    #[must_use]
    pub fn new(program: &Path, config: &str) -> Self {
        let folder = tempfile::Builder::new().prefix("rg").tempdir_in("/tmp").expect("a folder under /tmp");
        let file = folder.path().join("train.toml");
        std::fs::write(&file, config).expect("write the config");
        let mut train = Self { program: program.to_owned(), folder, options: Vec::new(), up: None };
        train.options = vec![
            "--config".into(),
            file.display().to_string(),
            "--listen".into(),
            "127.0.0.1:0".into(),
            "--instance".into(),
            train.instance().display().to_string(),
        ];
        train
    }

    /// Adds options for every command of this train.
    #[must_use]
    pub fn with(mut self, options: &[&str]) -> Self {
        self.options.extend(options.iter().map(|option| (*option).to_owned()));
        self
    }

    /// Serves at a fixed port from now on, so that an address outlives the service.
    ///
    /// # Panics
    /// If no port is free.
    #[must_use]
    pub fn at_fixed_port(mut self) -> Self {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = listener.local_addr().expect("its address").to_string();
        self.options
            .iter_mut()
            .filter(|option| *option == "127.0.0.1:0")
            .for_each(|option| option.clone_from(&address));
        self
    }

    /// The folder of this test.
    #[must_use]
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// The folder of the running train.
    #[must_use]
    pub fn instance(&self) -> PathBuf {
        self.folder.path().join("i")
    }

    /// A command of this train, for example `status`.
    #[must_use]
    pub fn command(&self, words: &[&str]) -> Command {
        let mut command = Command::new(&self.program);
        command.args(words).args(&self.options).stdin(Stdio::null());
        command
    }

    /// Runs a command of this train to its end.
    ///
    /// # Panics
    /// If it cannot be started.
    #[must_use]
    pub fn run(&self, words: &[&str]) -> Output {
        self.command(words).output().expect("start the program")
    }

    /// Starts `railgrip up` with its log in a file.
    ///
    /// # Panics
    /// If it cannot be started.
    pub fn start(&mut self) {
        self.start_with(&[]);
    }

    /// Starts `railgrip up` with further options.
    ///
    /// # Panics
    /// If it cannot be started.
    pub fn start_with(&mut self, words: &[&str]) {
        let log = std::fs::OpenOptions::new().create(true).append(true).open(self.log_file()).expect("log");
        let words: Vec<&str> = std::iter::once("up").chain(words.iter().copied()).collect();
        let mut command = self.command(&words);
        command.stdout(Stdio::null()).stderr(log);
        self.up = Some(command.spawn().expect("start `up`"));
    }

    /// Starts `railgrip up` with a standard input to write to.
    ///
    /// # Panics
    /// If it cannot be started.
    pub fn start_fed(&mut self) -> ChildStdin {
        let log = std::fs::OpenOptions::new().create(true).append(true).open(self.log_file()).expect("log");
        let mut command = self.command(&["up"]);
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(log);
        let mut up = command.spawn().expect("start `up`");
        let input = up.stdin.take().expect("piped");
        self.up = Some(up);
        input
    }

    /// Everything that the train logged so far.
    #[must_use]
    pub fn log(&self) -> String {
        std::fs::read_to_string(self.log_file()).unwrap_or_default()
    }

    fn log_file(&self) -> PathBuf {
        self.folder.path().join("log")
    }

    /// A client of the train's HTTP service, as soon as it has an address.
    #[must_use]
    pub fn http(&self) -> Option<Http> {
        let text = std::fs::read_to_string(self.instance().join("http.address")).ok()?;
        let address = text.trim().trim_start_matches("http://");
        (!address.is_empty()).then(|| Http::new(address))
    }

    /// Waits until every wagon is live; says how long it took.
    ///
    /// # Panics
    /// If that takes longer than `patience`; shows the log.
    pub fn wait_ready(&self, patience: Duration) -> Duration {
        let started = Instant::now();
        match within(patience, || self.http().filter(Http::ready)) {
            Some(_) => started.elapsed(),
            None => {
                let why = self.http().and_then(|http| http.get("/health/ready"));
                panic!("not ready after {patience:?}: {why:?}\n{:?}\n{}", self.processes(), self.log())
            }
        }
    }

    /// The processes that run now.
    #[must_use]
    pub fn processes(&self) -> Vec<Process> {
        of_instance(&self.instance())
    }

    /// Waits until none of `old` runs any more; what they serve must not pass for the new train.
    ///
    /// # Panics
    /// If one does not leave within 15 s.
    pub fn wait_gone(&self, old: &[Process]) {
        let gone = within(Duration::from_secs(15), || {
            self.processes().iter().all(|process| !old.contains(process)).then_some(())
        });
        assert!(gone.is_some(), "orphans: {:?}\n{}", self.processes(), self.log());
    }

    /// The process of a role, once it runs.
    ///
    /// # Panics
    /// If there is none within 5 s.
    #[must_use]
    pub fn process(&self, role: &str) -> Process {
        within(Duration::from_secs(5), || self.processes().into_iter().find(|process| process.role == role))
            .unwrap_or_else(|| panic!("no {role}: {:?}\n{}", self.processes(), self.log()))
    }

    /// Waits for another process in a role than `old`.
    ///
    /// # Panics
    /// If there is none within 10 s.
    #[must_use]
    pub fn successor(&self, old: &Process) -> Process {
        let other = |process: &Process| process.role == old.role && process.pid != old.pid;
        within(Duration::from_secs(10), || self.processes().into_iter().find(other))
            .unwrap_or_else(|| panic!("no new {}: {:?}\n{}", old.role, self.processes(), self.log()))
    }

    /// Sends SIGTERM to `up` and waits for its end.
    ///
    /// # Panics
    /// If it does not end within 15 s.
    pub fn stop(&mut self) -> ExitStatus {
        if let Some(up) = &self.up {
            Process { pid: up.id().cast_signed(), role: "up".into() }.signal(Signal::TERM);
        }
        self.wait()
    }

    /// Waits until `up` ends by itself.
    ///
    /// # Panics
    /// If it does not end within 15 s.
    pub fn wait(&mut self) -> ExitStatus {
        let mut up = self.up.take().expect("`up` was started");
        let status = within(Duration::from_secs(15), || up.try_wait().ok().flatten());
        status.unwrap_or_else(|| {
            let _ = up.kill();
            let _ = up.wait();
            panic!("`up` does not end: {:?}\n{}", self.processes(), self.log())
        })
    }

    /// `kill -9` of `up`.
    pub fn kill_up(&mut self) {
        if let Some(mut up) = self.up.take() {
            let _ = up.kill();
            let _ = up.wait();
        }
    }

    /// True while `up` runs.
    pub fn is_up(&mut self) -> bool {
        self.up.as_mut().is_some_and(|up| matches!(up.try_wait(), Ok(None)))
    }

    /// Names in `/dev/shm` that belong to this train.
    #[must_use]
    pub fn shared_memory(&self) -> Vec<String> {
        let Some(prefix) = self.prefix() else { return Vec::new() };
        let Ok(entries) = std::fs::read_dir("/dev/shm") else { return Vec::new() };
        let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
        names.filter(|name| name.starts_with(&prefix)).collect()
    }

    /// The prefix that the holder wrote down.
    fn prefix(&self) -> Option<String> {
        let text = std::fs::read_to_string(self.instance().join("iceoryx2.toml")).ok()?;
        let line = text.lines().find(|line| line.starts_with("prefix"))?;
        Some(line.split('"').nth(1)?.to_owned())
    }
}

impl Drop for TrainUnderTest {
    fn drop(&mut self) {
        self.kill_up();
        for process in self.processes() {
            process.kill();
        }
        let _ = within(Duration::from_secs(5), || self.processes().is_empty().then_some(()));
        for name in self.shared_memory() {
            let path = Path::new("/dev/shm").join(name);
            let _ = std::fs::remove_file(&path).or_else(|_| std::fs::remove_dir_all(&path));
        }
    }
}
