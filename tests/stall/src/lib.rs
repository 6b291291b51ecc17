//! A disk that hangs on command. Loaded into a program with `LD_PRELOAD`, this library replaces the functions of libc
//! through which the program accesses files. A call that concerns a file in one of the given folders waits while a flag
//! file exists. Every other call goes straight to the kernel.
//!
//! | environment variable | meaning |
//! |---|---|
//! | `STALL_WHILE` | the flag file: while it exists, calls wait. Each call that waits adds a line to the file of this name with `.held` at its end, such as `write /tmp/logs/a.mcap` |
//! | `STALL_UNDER` | the folders or files, with `:` between them |
//!
//! This shows what a hard NFS mount without its server does to a program: the call does not return, and a signal that
//! ends the process ends the call. It cannot show a frozen file system, whose calls nothing ends (`backseat-soak frozen`
//! shows that). It also misses accesses that do not use these functions: a mapped file, a direct system call, and
//! accesses within libc, such as those of `fopen`. Of the last, only the resolver is covered: `getaddrinfo` counts as a
//! read of `/etc/hosts`.

#![cfg(target_os = "linux")]
#![expect(
    unsafe_code,
    reason = "it has the signatures of libc's own functions, and passes their arguments to the kernel unread"
)]

use std::ffi::{CStr, c_char, c_int, c_long, c_uint, c_void};

use libc::{mode_t, off_t, size_t, ssize_t};

/// The time between two checks for the flag file, nanoseconds.
const LOOK_EVERY_NANOS: c_long = 10_000_000;
const PATH_BYTES: usize = 4096;

/// A text that is built without allocating, because a signal handler may call `write`.
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

    /// Adds as much as there is room for, and keeps a NUL at the end.
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
    // SAFETY: the name ends with a NUL. Nothing changes the environment of a program under test while it runs.
    let value = unsafe { libc::getenv(name.as_ptr()) };
    // SAFETY: the value ends with a NUL and stays valid.
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

/// Notes in the file beside the flag that a call waits.
fn tell(flag: &[u8], call: &str, about: &[u8]) {
    let (mut path, mut line) = (Text::new(), Text::new());
    path.add(flag);
    path.add(b".held");
    for part in [call.as_bytes(), b" ", about, b"\n"] {
        line.add(part);
    }
    let flags = libc::O_WRONLY | libc::O_CREAT | libc::O_APPEND | libc::O_CLOEXEC;
    // SAFETY: the path ends with a NUL, the length is that of the line, and the file is closed here, where it was
    // opened.
    unsafe {
        let file = libc::syscall(libc::SYS_openat, libc::AT_FDCWD, path.pointer(), flags, 0o600);
        if file >= 0 {
            libc::syscall(libc::SYS_write, file, line.pointer(), line.length);
            libc::syscall(libc::SYS_close, file);
        }
    }
}

/// Waits while the flag file exists, if this call concerns a file in one of the folders. `about` is only called in that
/// case.
fn wait(call: &str, about: impl FnOnce(&mut Text)) {
    let (Some(flag), Some(folders)) = (variable(c"STALL_WHILE"), variable(c"STALL_UNDER")) else {
        return;
    };
    // SAFETY: libc gives each thread its own `errno`.
    let errno = unsafe { libc::__errno_location() };
    // SAFETY: as above. A signal handler must leave `errno` unchanged.
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
                // SAFETY: the time is a local variable, and the remaining time is not needed.
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
        // SAFETY: guaranteed by the caller.
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
        // SAFETY: the path ends with a NUL, and no more is written than fits.
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

/// The kernel's return value, converted to that of a libc function.
fn int(returned: c_long) -> c_int {
    c_int::try_from(returned).unwrap_or(-1)
}

fn size(returned: c_long) -> ssize_t {
    ssize_t::try_from(returned).unwrap_or(-1)
}

/// Functions that take an open file, each with its system call.
macro_rules! of_a_file {
    ($($name:ident($call:ident $(, $argument:ident: $kind:ty)*) -> $convert:ident $returned:ty;)*) => {
        $(
            /// As in libc, after a stall has ended.
            ///
            /// # Safety
            /// As in libc.
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name(file: c_int $(, $argument: $kind)*) -> $returned {
                wait_for_file(stringify!($name), file);
                // SAFETY: the caller meets the requirements of libc's function, and those of the kernel are the same.
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

/// Functions that take a path, each with its system call.
macro_rules! of_a_path {
    ($($name:ident($call:ident, $($before:expr,)? path $(, $argument:ident: $kind:ty)* $(; $after:expr)?);)*) => {
        $(
            /// As in libc, after a stall has ended.
            ///
            /// # Safety
            /// As in libc.
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name(path: *const c_char $(, $argument: $kind)*) -> c_int {
                // SAFETY: a path passed to libc ends with a NUL.
                unsafe { wait_for_path(stringify!($name), path) };
                // SAFETY: the caller meets the requirements of libc's function, and those of the kernel are the same.
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

/// As in libc, after a stall has ended.
///
/// # Safety
/// As in libc.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rename(from: *const c_char, to: *const c_char) -> c_int {
    // SAFETY: a path passed to libc ends with a NUL.
    unsafe { wait_for_path("rename", from) };
    // SAFETY: the caller meets the requirements of libc's function, and those of the kernel are the same.
    int(unsafe { libc::syscall(libc::SYS_renameat2, libc::AT_FDCWD, from, libc::AT_FDCWD, to, 0) })
}

/// As in libc, after a stall has ended. (Rust's `std` uses this to check whether a file exists.)
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
    // SAFETY: a path passed to libc ends with a NUL.
    unsafe { wait_for_path("statx", path) };
    // SAFETY: the caller meets the requirements of libc's function, and those of the kernel are the same.
    int(unsafe { libc::syscall(libc::SYS_statx, folder, path, flags, mask, told) })
}

type Resolve =
    unsafe extern "C" fn(*const c_char, *const c_char, *const libc::addrinfo, *mut *mut libc::addrinfo) -> c_int;

/// As in libc, after a stall has ended.
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
    // SAFETY: libc's function of this name has this type.
    let resolve: Resolve = unsafe { std::mem::transmute::<*mut c_void, Resolve>(next) };
    // SAFETY: the caller meets its requirements.
    unsafe { resolve(node, service, hints, found) }
}
