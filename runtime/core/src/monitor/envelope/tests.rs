//! The numbers that a judgement is made of, each compared with its formula.
