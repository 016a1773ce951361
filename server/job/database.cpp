#include "server/job/database.hpp"

#include "engine/base/error.hpp"

namespace hoodoo::job {

Database::Database(const std::filesystem::path& file) : name(file.string()) {
  const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
  if (sqlite3_open_v2(name.c_str(), &handle, flags, nullptr) != SQLITE_OK) {
    const std::string why = handle != nullptr ? sqlite3_errmsg(handle) : "out of memory";
    sqlite3_close(handle);
    throw Error(Fault::io, name, why);
  }
}

void Database::execute(const char* sql) const {
  if (sqlite3_exec(handle, sql, nullptr, nullptr, nullptr) != SQLITE_OK) {
    throw Error(Fault::io, name, sqlite3_errmsg(handle));
  }
}

}  // namespace hoodoo::job
