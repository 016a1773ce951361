/** One of server-sent events (WHATWG HTML, 9.2). */
export interface ServerEvent { id: string; event: string; data: string }

/** The events of a stream, without comments; the last one only when it is whole. */
export async function* readEvents(stream: ReadableStream<Uint8Array>): AsyncGenerator<ServerEvent> {
  const reader = stream.getReader();
  const decoder = new TextDecoder();
  let text = '', id = '', event = '', data: string[] = [];
  try {
    for (;;) {
      const { value, done } = await reader.read();
      if (done) return;
      text += decoder.decode(value, { stream: true });
      const lines = text.split(/\r\n|\n|\r(?!$)/);
      text = lines.pop() ?? '';
      for (const line of lines) {
        if (line === '') {
          if (data.length > 0) yield { id, event: event || 'message', data: data.join('\n') };
          event = '';
          data = [];
          continue;
        }
        const [, name, content] = /^([^:]*)(?:: ?(.*))?$/s.exec(line) ?? [];
        if (name === 'id') id = content ?? '';
        if (name === 'event') event = content ?? '';
        if (name === 'data') data.push(content ?? '');
      }
    }
  } finally {
    await reader.cancel().catch(() => undefined);
  }
}
