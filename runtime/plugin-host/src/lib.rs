//! Runs plugins: sandboxed WebAssembly components with budgets.
