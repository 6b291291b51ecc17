//! A disk that hangs on command. Loaded into a program by `LD_PRELOAD`, this library takes the place of the functions of
//! libc by which the program reaches files. Each of them waits while a flag file exists, where it is about a file in one of
//! the given folders; everything else goes straight to the kernel.
//!
//! | variable of the environment | meaning |
//! |---|---|
//! | `STALL_WHILE` | the flag file: while it exists, calls wait. Each call that waits adds a line to the file of this name with `.held` at its end, such as `write /tmp/logs/a.mcap` |
//! | `STALL_UNDER` | the folders or files, with `:` between them |
//!
//! It shows what a hard NFS mount without its server does to a program: the call does not return, and a signal that ends the
//! process ends the call. It cannot show a frozen file system, whose calls nothing ends (`backseat-soak frozen` shows that),
//! nor what reaches a file without these functions: a mapped file, a system call made directly, and what libc does inside of
//! itself (`fopen`, say). Of the last, the resolver is caught as a whole: `getaddrinfo` counts as a read of `/etc/hosts`.

#![cfg(target_os = "linux")]
#![expect(
    unsafe_code,
    reason = "it has the signatures of libc's own functions, and hands their arguments to the kernel unread"
)]

use std::ffi::{CStr, c_char, c_int, c_long, c_uint, c_void};

use libc::{mode_t, off_t, size_t, ssize_t};

/// How long between two looks for the flag file, nanoseconds.
const LOOK_EVERY_NANOS: c_long = 10_000_000;
const PATH_BYTES: usize = 4096;

/// A text that is put together without an allocation, for `write` may be called by a signal's handler.
struct Text {
    bytes: [u8; PATH_BYTES],
    length: usize,
}

impl Text {
    const fn new() -> Self {
        Self {
            bytes: [0; PATH_BYTES],
            length: 0,
        }
    }

    /// Adds what there is room for, and leaves a NUL at the end.
    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes.iter().take(PATH_BYTES - 1 - self.length) {
            self.bytes[self.length] = *byte;
            self.length += 1;
        }
    }

    fn bytes(&self) -> &[u8] {
        &self.bytes[..self.length]
    }

    fn pointer(&self) -> *const c_char {
        self.bytes.as_ptr().cast()
    }
}

fn variable(name: &CStr) -> Option<&'static [u8]> {
    // SAFETY: the name ends with a NUL. Nobody changes the environment of a program under test while it runs.
    let value = unsafe { libc::getenv(name.as_ptr()) };
    // SAFETY: what is there ends with a NUL and stays.
    (!value.is_null()).then(|| unsafe { CStr::from_ptr(value) }.to_bytes())
}

/// Whether the flag file exists.
fn stalled(flag: &[u8]) -> bool {
    let mut path = Text::new();
    path.add(flag);
    // SAFETY: the path ends with a NUL.
    unsafe { libc::syscall(libc::SYS_faccessat, libc::AT_FDCWD, path.pointer(), libc::F_OK) == 0 }
}

fn is_under(path: &[u8], folders: &[u8]) -> bool {
    folders.split(|byte| *byte == b':').any(|folder| {
        !folder.is_empty()
            && path
                .strip_prefix(folder)
                .is_some_and(|rest| matches!(rest.first(), None | Some(b'/' | b' ')))
    })
}

/// Says in the file beside the flag that a call waits.
fn tell(flag: &[u8], call: &str, about: &[u8]) {
    let (mut path, mut line) = (Text::new(), Text::new());
    path.add(flag);
    path.add(b".held");
    for part in [call.as_bytes(), b" ", about, b"\n"] {
        line.add(part);
    }
    let flags = libc::O_WRONLY | libc::O_CREAT | libc::O_APPEND | libc::O_CLOEXEC;
    // SAFETY: the path ends with a NUL, the line is as long as it says, and the file is closed by whoever opened it.
    unsafe {
        let file = libc::syscall(libc::SYS_openat, libc::AT_FDCWD, path.pointer(), flags, 0o600);
        if file >= 0 {
            libc::syscall(libc::SYS_write, file, line.pointer(), line.length);
            libc::syscall(libc::SYS_close, file);
        }
    }
}

/// Waits while the flag file exists, where this call is about a file in one of the folders. `about` is asked only then.
fn wait(call: &str, about: impl FnOnce(&mut Text)) {
    let (Some(flag), Some(folders)) = (variable(c"STALL_WHILE"), variable(c"STALL_UNDER")) else {
        return;
    };
    // SAFETY: libc gives each thread a place of its own.
    let errno = unsafe { libc::__errno_location() };
    // SAFETY: as above. A signal's handler must leave it as it was.
    let before = unsafe { *errno };
    if stalled(flag) {
        let mut path = Text::new();
        about(&mut path);
        if is_under(path.bytes(), folders) {
            tell(flag, call, path.bytes());
            while stalled(flag) {
                let pause = libc::timespec {
                    tv_sec: 0,
                    tv_nsec: LOOK_EVERY_NANOS,
                };
                // SAFETY: the time is ours, and what is left of it is of no interest.
                unsafe { libc::nanosleep(&raw const pause, std::ptr::null_mut()) };
            }
        }
    }
    // SAFETY: as above.
    unsafe { *errno = before };
}

/// # Safety
/// The path ends with a NUL.
unsafe fn wait_for_path(call: &str, path: *const c_char) {
    wait(call, |text| {
        // SAFETY: the caller's promise.
        text.add(unsafe { CStr::from_ptr(path) }.to_bytes());
    });
}

fn wait_for_file(call: &str, file: c_int) {
    wait(call, |text| {
        let mut link = Text::new();
        link.add(b"/proc/self/fd/");
        let mut digits = [0; 10];
        let mut rest = file.unsigned_abs();
        let mut first = digits.len();
        loop {
            first -= 1;
            digits[first] = b'0' + u8::try_from(rest % 10).unwrap_or(0);
            rest /= 10;
            if rest == 0 {
                break;
            }
        }
        link.add(&digits[first..]);
        // SAFETY: the path ends with a NUL, and no more is written than there is room for.
        let length = unsafe {
            libc::syscall(
                libc::SYS_readlinkat,
                libc::AT_FDCWD,
                link.pointer(),
                text.bytes.as_mut_ptr(),
                PATH_BYTES - 1,
            )
        };
        text.length = usize::try_from(length).unwrap_or(0);
    });
}

/// What the kernel returned, as the function of libc returns it.
fn int(returned: c_long) -> c_int {
    c_int::try_from(returned).unwrap_or(-1)
}

fn size(returned: c_long) -> ssize_t {
    ssize_t::try_from(returned).unwrap_or(-1)
}

/// Functions that are given an open file, with the system call that each is.
macro_rules! of_a_file {
    ($($name:ident($call:ident $(, $argument:ident: $kind:ty)*) -> $convert:ident $returned:ty;)*) => {
        $(
            /// As in libc, once it may.
            ///
            /// # Safety
            /// As in libc.
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name(file: c_int $(, $argument: $kind)*) -> $returned {
                wait_for_file(stringify!($name), file);
                // SAFETY: the caller keeps what libc's function asks of it, and the kernel's is the same.
                $convert(unsafe { libc::syscall(libc::$call, file $(, $argument)*) })
            }
        )*
    };
}

of_a_file! {
    read(SYS_read, buffer: *mut c_void, count: size_t) -> size ssize_t;
    readv(SYS_readv, parts: *const libc::iovec, count: c_int) -> size ssize_t;
    write(SYS_write, buffer: *const c_void, count: size_t) -> size ssize_t;
    writev(SYS_writev, parts: *const libc::iovec, count: c_int) -> size ssize_t;
    fsync(SYS_fsync) -> int c_int;
    fdatasync(SYS_fdatasync) -> int c_int;
    ftruncate64(SYS_ftruncate, length: off_t) -> int c_int;
    flock(SYS_flock, operation: c_int) -> int c_int;
    close(SYS_close) -> int c_int;
}

/// Functions that are given a path, with the system call that each is.
macro_rules! of_a_path {
    ($($name:ident($call:ident, $($before:expr,)? path $(, $argument:ident: $kind:ty)* $(; $after:expr)?);)*) => {
        $(
            /// As in libc, once it may.
            ///
            /// # Safety
            /// As in libc.
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name(path: *const c_char $(, $argument: $kind)*) -> c_int {
                // SAFETY: a path that libc is given ends with a NUL.
                unsafe { wait_for_path(stringify!($name), path) };
                // SAFETY: the caller keeps what libc's function asks of it, and the kernel's is the same.
                int(unsafe { libc::syscall(libc::$call, $($before,)? path $(, $argument)* $(, $after)?) })
            }
        )*
    };
}

of_a_path! {
    open(SYS_openat, libc::AT_FDCWD, path, flags: c_int, mode: mode_t);
    open64(SYS_openat, libc::AT_FDCWD, path, flags: c_int, mode: mode_t);
    unlink(SYS_unlinkat, libc::AT_FDCWD, path; 0);
    mkdir(SYS_mkdirat, libc::AT_FDCWD, path, mode: mode_t);
}

/// As in libc, once it may.
///
/// # Safety
/// As in libc.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rename(from: *const c_char, to: *const c_char) -> c_int {
    // SAFETY: a path that libc is given ends with a NUL.
    unsafe { wait_for_path("rename", from) };
    // SAFETY: the caller keeps what libc's function asks of it, and the kernel's is the same.
    int(unsafe { libc::syscall(libc::SYS_renameat2, libc::AT_FDCWD, from, libc::AT_FDCWD, to, 0) })
}

/// As in libc, once it may. (Rust's `std` looks whether a file is there by this.)
///
/// # Safety
/// As in libc.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn statx(
    folder: c_int,
    path: *const c_char,
    flags: c_int,
    mask: c_uint,
    told: *mut libc::statx,
) -> c_int {
    // SAFETY: a path that libc is given ends with a NUL.
    unsafe { wait_for_path("statx", path) };
    // SAFETY: the caller keeps what libc's function asks of it, and the kernel's is the same.
    int(unsafe { libc::syscall(libc::SYS_statx, folder, path, flags, mask, told) })
}

type Resolve =
    unsafe extern "C" fn(*const c_char, *const c_char, *const libc::addrinfo, *mut *mut libc::addrinfo) -> c_int;

/// As in libc, once it may.
///
/// # Safety
/// As in libc.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn getaddrinfo(
    node: *const c_char,
    service: *const c_char,
    hints: *const libc::addrinfo,
    found: *mut *mut libc::addrinfo,
) -> c_int {
    wait("getaddrinfo", |text| text.add(b"/etc/hosts"));
    // SAFETY: the name ends with a NUL.
    let next = unsafe { libc::dlsym(libc::RTLD_NEXT, c"getaddrinfo".as_ptr()) };
    if next.is_null() {
        return libc::EAI_SYSTEM;
    }
    // SAFETY: libc's function of this name is of this type.
    let resolve: Resolve = unsafe { std::mem::transmute::<*mut c_void, Resolve>(next) };
    // SAFETY: the caller keeps what it asks.
    unsafe { resolve(node, service, hints, found) }
}
